#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "haptic_server/engine/contact/near_bodies.h"
#include "haptic_server/engine/force/spring_damper.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"

namespace haptics::bench {
namespace {

/// The other phases of a contact tick, one at a time, each on what the phases before it leave along the path of a scene
/// whose first body holds the HIP and stands at the origin.
class Phases {
 public:
  explicit Phases(Scene scene) {
    Replay replay(std::move(scene));
    bodies_ = replay.scene().bodies;
    const CollisionMesh& surface = *bodies_.front().surface;
    Vec3 before = replay.state().hip;
    for (const Vec3 hip : replay.scene().path) {
      const ContactResult contact = replay.tick();
      const double speed_m_per_s = glm::dot(hip - before, contact.normal) / kPeriod_s;
      places_.push_back({hip, heldFoot(surface, replay.state(), hip), contact, speed_m_per_s});
      before = hip;
    }
    state_ = replay.state();
  }

  /// As of bodies that move: those at rest are spared it.
  void poses() noexcept {
    for (Body& body : bodies_) {
      body.update();
      benchmark::DoNotOptimize(body);
    }
  }
  /// As beside bodies that can block the way; a body that is alone is spared it.
  void gather() noexcept {
    state_.hip = places_[at_].hip;
    state_.ihip = places_[at_].contact.ihip;
    near_.gather(bodies_, state_, next().hip, work_);
    benchmark::DoNotOptimize(near_);
  }
  void sign() noexcept {
    const Place& place = next();
    bool outside = bodies_.front().surface->isOutside(place.foot, place.hip);
    benchmark::DoNotOptimize(outside);
  }
  void force() noexcept {
    constexpr Stiffness kMaterial{1000, 0.5};
    const auto& [hip, foot, contact, speed_m_per_s] = next();
    constexpr double kMax_N = 10;
    static_cast<void>(felt_.follow(kMaterial, contact.penetration_m, speed_m_per_s, kMax_N, kPeriod_s));
    benchmark::DoNotOptimize(felt_);
    SpringDamperForce force = springDamper(contact.penetration_m, contact.normal, speed_m_per_s, felt_.value());
    benchmark::DoNotOptimize(force);
  }

 private:
  static constexpr double kPeriod_s = 1e-3;
  struct Place {
    Vec3 hip;
    ClosestPoint foot;
    ContactResult contact;
    double speed_m_per_s;  ///< Of the HIP along the contact's normal.
  };

  const Place& next() noexcept {
    if (++at_ == places_.size()) at_ = 0;
    return places_[at_];
  }

  std::vector<Body> bodies_;
  std::vector<Place> places_;
  std::size_t at_ = 0;
  ContactState state_;
  NearBodies near_;
  ContactWork work_;
  RateLimitedStiffness felt_;
};

template <void (Phases::*kPhase)() noexcept>
void phaseAlone(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  Phases phases(trajectory.make(segments));
  for (auto _ : state) (phases.*kPhase)();
}

}  // namespace

void registerPhases(std::span<const std::uint32_t> sizes) {
  for (const std::uint32_t n : sizes) {
    for (const Trajectory& t : {kRubbing, kSlide}) {
      benchmark::RegisterBenchmark(nameOf("phase/poses", t, n).c_str(), phaseAlone<&Phases::poses>, t, n);
      benchmark::RegisterBenchmark(nameOf("phase/gather", t, n).c_str(), phaseAlone<&Phases::gather>, t, n);
      benchmark::RegisterBenchmark(nameOf("phase/sign", t, n).c_str(), phaseAlone<&Phases::sign>, t, n);
      benchmark::RegisterBenchmark(nameOf("phase/force", t, n).c_str(), phaseAlone<&Phases::force>, t, n);
    }
  }
}

}  // namespace haptics::bench
