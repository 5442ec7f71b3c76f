#include "tests/eval/stability/methods.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/force/spring_damper.h"
#include "haptic_server/engine/force/velocity_estimator.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

/// Backward difference.
class RawVelocity {
 public:
  RawVelocity(double period_s, double /*resolution_m*/) : period_(period_s) {}
  void reset(Vec3 position) { last_ = position; }
  Vec3 update(Vec3 position) {
    const Vec3 velocity = (position - last_) / period_;
    last_ = position;
    return velocity;
  }

 private:
  double period_;
  Vec3 last_{0};
};

class FilteredVelocity : public VelocityEstimator {
 public:
  FilteredVelocity(double period_s, double /*resolution_m*/) : VelocityEstimator(period_s) {}
};

/// First-order adaptive windowing (Janabi-Sharifi, Hayward & Chen 2000), end-fit, per axis: the longest window whose
/// positions all lie within an encoder step of a straight line.
class WindowedVelocity {
 public:
  WindowedVelocity(double period_s, double resolution_m) : period_(period_s), noise_(resolution_m) {}
  void reset(Vec3 position) { past_.fill(position); }
  Vec3 update(Vec3 position) {
    std::shift_right(past_.begin(), past_.end(), 1);
    past_[0] = position;
    return {along(0), along(1), along(2)};
  }

 private:
  static constexpr int kLongest = 16;

  [[nodiscard]] double along(int axis) const {
    double slope = past_[0][axis] - past_[1][axis];
    for (std::size_t n = 2; n <= kLongest; ++n) {
      const double next = (past_[0][axis] - past_[n][axis]) / static_cast<double>(n);
      for (std::size_t i = 1; i < n; ++i) {
        const double straight = past_[0][axis] - static_cast<double>(i) * next;
        if (std::abs(past_[i][axis] - straight) > noise_) return slope / period_;
      }
      slope = next;
    }
    return slope / period_;
  }

  double period_;
  double noise_;
  std::array<Vec3, kLongest + 1> past_{};
};

/// Spring and damper on the contact core, by an estimate of velocity.
template <class Velocity>
class SpringAndDamper : public StabilityMethod {
 public:
  explicit SpringAndDamper(const Rendering& r)
      : rendering_(r), contact_(*r.ground), velocity_(r.period_s, r.device.resolution_m) {}

  Vec3 tick(Vec3 measured) override {
    if (!attached_) {
      contact_.place(measured);
      velocity_.reset(measured);
      attached_ = true;
    }
    const Vec3 velocity = velocity_.update(measured);
    const ContactResult contact = contact_.follow(measured);
    Vec3 force(0);
    if (contact.touching) {
      const double depth = contact.penetration_m;
      const Vec3 direction = depth > 0 ? (contact.ihip - measured) / depth : contact.normal;
      const auto felt = springDamper(depth, direction, glm::dot(velocity, direction),
                                     {rendering_.stiffness_N_per_m, rendering_.damping_Ns_per_m});
      force = felt.spring + felt.damping;
    }
    return limitMagnitude(controlled(measured, force), rendering_.device.maxForce_N);
  }

 protected:
  [[nodiscard]] virtual Vec3 controlled(Vec3 /*measured*/, Vec3 force) { return force; }
  const Rendering& rendering() const { return rendering_; }

 private:
  Rendering rendering_;
  GroundContact contact_;
  Velocity velocity_;
  bool attached_ = false;
};

/// Time-domain passivity control (Hannaford & Ryu 2002, impedance causality), the energy accounted on what was written.
class PassivityControl final : public SpringAndDamper<RawVelocity> {
 public:
  using SpringAndDamper<RawVelocity>::SpringAndDamper;

 protected:
  Vec3 controlled(Vec3 measured, Vec3 force) override {
    if (!seen_) last_ = measured;
    seen_ = true;
    const Vec3 way = measured - last_;
    last_ = measured;
    absorbed_J_ -= glm::dot(written_, way);
    const double squared = squaredLength(way);
    const double still = rendering().device.resolution_m / 2;
    if (absorbed_J_ < 0 && squared > still * still) {
      // alpha v T v = -E; no more than stops the device within a tick.
      const double most = rendering().device.apparentMass_kg / rendering().period_s;
      const double alpha = std::min(-absorbed_J_ * rendering().period_s / squared, most);
      force -= alpha / rendering().period_s * way;
    }
    written_ = limitMagnitude(force, rendering().device.maxForce_N);
    return written_;
  }

 private:
  bool seen_ = false;
  Vec3 last_{0};
  Vec3 written_{0};
  double absorbed_J_ = 0;
};

template <class Velocity>
std::unique_ptr<StabilityMethod> makeSpringAndDamper(const Rendering& rendering) {
  return std::make_unique<SpringAndDamper<Velocity>>(rendering);
}

/// As toolkits have it: never less damping than the maker publishes for the device.
std::unique_ptr<StabilityMethod> makeLowPass(const Rendering& rendering) {
  Rendering damped = rendering;
  damped.damping_Ns_per_m = std::max(damped.damping_Ns_per_m, rendering.device.maxDamping_Ns_per_m);
  return makeSpringAndDamper<FilteredVelocity>(damped);
}

/// Damped by what hold and delay feed in.
std::unique_ptr<StabilityMethod> makeWindowed(const Rendering& rendering) {
  Rendering damped = rendering;
  damped.damping_Ns_per_m += rendering.stiffness_N_per_m * (rendering.period_s / 2 + rendering.delay_s);
  return makeSpringAndDamper<WindowedVelocity>(damped);
}

}  // namespace

std::unique_ptr<StabilityMethod> makeOurs(const Rendering& rendering) {
  return std::make_unique<ProductionStep>(
      sceneOf(*rendering.ground, rendering.stiffness_N_per_m, rendering.damping_Ns_per_m),
      serverConfigFor(rendering.device, 1 / rendering.period_s, rendering.delay_s));
}

std::unique_ptr<StabilityMethod> makeBare(const Rendering& rendering) {
  return makeSpringAndDamper<RawVelocity>(rendering);
}

const std::vector<MethodEntry>& stabilityMethods() {
  static const std::vector<MethodEntry> methods{
      {"nothing", "nothing", "spring, damper on raw differences", makeBare},
      {"passivity_control", "passivity control", "Hannaford & Ryu 2002",
       [](const Rendering& r) -> std::unique_ptr<StabilityMethod> { return std::make_unique<PassivityControl>(r); }},
      {"spring_damper_low_pass", "damper, 100 Hz low pass", "no less than the maker's largest", makeLowPass},
      {"adaptive_window", "adaptive window", "and damping of K (T / 2 + delay)", makeWindowed},
      {kOursMethod, "observer lead (ours)", "as the server has it", makeOurs}};
  return methods;
}

}  // namespace haptics::eval
