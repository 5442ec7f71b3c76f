#pragma once

#include "haptic_server/contact/contact_tick_impl.h"
#include "tests/eval/baselines/moeller_trumbore.h"
#include "tests/eval/renderer.h"

/// Ours with one correction switched off at a time, and with the search in float: policies of the contact core.
namespace haptics::eval {

struct WithoutFeatureCodes : AllCorrections {
  static constexpr bool kFeatureCodes = false;
};
struct WithoutPseudonormals : AllCorrections {
  static constexpr bool kPseudonormals = false;
};
struct WithoutSameTickSearch : AllCorrections {
  static constexpr bool kSameTickSearch = false;
};
struct WithoutExitRetest : AllCorrections {
  static constexpr bool kExitRetest = false;
};
struct WithoutObjectFrames : AllCorrections {
  static constexpr bool kObjectFrameSegments = false;
};
struct WithoutContainment : AllCorrections {
  static constexpr bool kContainment = false;
};
struct WithoutGuard : AllCorrections {
  static constexpr bool kGuard = false;
};
struct WithoutSeveralSurfaces : AllCorrections {
  static constexpr bool kSeveralSurfaces = false;
};
struct WithoutBudget : AllCorrections {
  static constexpr bool kBoundedSearch = false;
};
struct WithoutScaleFreeTolerances : AllCorrections {
  static constexpr bool kScaleFreeTolerances = false;
};
struct WithoutSubsteps : AllCorrections {
  static constexpr bool kSubsteps = false;
};
struct WithoutWatertightTest : AllCorrections {
  using SegmentTest = MoellerTrumbore;
};
struct InFloat : AllCorrections {
  static constexpr bool kRegionSteps = false;
  [[nodiscard]] static Foot closestPoint(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept;
};

/// The contact core under a policy, with the spring. The rest of the step is left out: an edit may make the force step.
template <class Corrections>
class OursUnder final : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const Surface>> bodies, std::span<const Pose> poses, Vec3 hip) override {
    surfaces_.assign(bodies.begin(), bodies.end());
    bodies_.clear();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Body& body = bodies_.emplace_back();
      body.surface = bodies[i].get();
      body.previous = body.current = poses[i];
      body.update();
    }
    place(hip);
  }
  void place(Vec3 hip) override { haptics::place(contact_, hip); }
  /// Of surfaces: the bodies stay the same.
  void edit(const EditedScene& scene, Vec3 /*hip*/) override {
    std::vector<BodyOrigin> origins;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      origins.push_back({static_cast<int>(i), scene.bodies[i] != surfaces_[i]});
      bodies_[i].surface = scene.bodies[i].get();
      bodies_[i].previous = bodies_[i].current;
      bodies_[i].update();
    }
    surfaces_.assign(scene.bodies.begin(), scene.bodies.end());
    (void)reseat(contact_, bodies_, origins);
  }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      bodies_[i].previous = bodies_[i].current;
      bodies_[i].current = poses[i];
      bodies_[i].update();
    }
    const ContactResult contact = followContact<Corrections>(bodies_, contact_, hip);
    return {contact.touching, contact.ihip, spring_N_per_m() * (contact.ihip - hip), contact.work.triangles};
  }

 private:
  std::vector<std::shared_ptr<const Surface>> surfaces_;
  std::vector<Body> bodies_;
  ContactState contact_;
};

}  // namespace haptics::eval
