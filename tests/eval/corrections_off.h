#pragma once

#include "haptic_server/engine/contact/contact_tick.h"
#include "tests/eval/renderer.h"

/// Ours with one correction switched off at a time, and with the search in float.
namespace haptics::eval {

/// MoellerTrumbore::enters().
[[nodiscard]] bool entersByRay(Vec3 from, Vec3 to, const TriangleRecord& record, bool twoSided,
                               Crossing& crossing) noexcept;
/// Segment::enters(), without the rims that close gaps.
[[nodiscard]] bool entersAlone(Vec3 from, Vec3 to, const TriangleRecord& record, bool twoSided,
                               Crossing& crossing) noexcept;
/// closestOn() with every operation in float, in the body's frame.
[[nodiscard]] ClosestPoint closestInFloat(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept;

inline constexpr Corrections kWithoutFeatureCodes{.featureCodes = false};
inline constexpr Corrections kWithoutPseudonormals{.pseudonormals = false};
inline constexpr Corrections kWithoutSameTickSearch{.sameTickSearch = false};
inline constexpr Corrections kWithoutExitRetest{.exitRetest = false};
inline constexpr Corrections kWithoutObjectFrames{.objectFrameSegments = false};
inline constexpr Corrections kWithoutContainment{.containment = false};
inline constexpr Corrections kWithoutGuard{.guard = false};
inline constexpr Corrections kWithoutSeveralSurfaces{.severalSurfaces = false};
inline constexpr Corrections kWithoutBudget{.boundedSearch = false};
inline constexpr Corrections kWithoutScaleFreeTolerances{.scaleFreeTolerances = false};
inline constexpr Corrections kWithoutSubsteps{.substeps = false};
inline constexpr Corrections kWithoutWatertightTest{.segmentTest = entersByRay};
inline constexpr Corrections kWithoutClosedGaps{.segmentTest = entersAlone};
inline constexpr Corrections kInFloat{.regionSteps = false, .closestPoint = closestInFloat};

/// The contact core with these corrections, and the spring. The rest of the step is left out: an edit may make the force
/// step.
class AblatedMethod final : public Renderer {
 public:
  explicit AblatedMethod(const Corrections& corrections) : corrections_(corrections) {}

  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override {
    setSpring();
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
  void place(Vec3 hip) override { haptics::resetContact(contact_, hip); }
  [[nodiscard]] bool turnsMirroredOver() const override { return true; }
  /// Of surfaces: the bodies stay the same.
  void edit(const EditedScene& scene, Vec3 /*hip*/) override {
    setSpring(scene.spring_N_per_m);
    std::vector<BodyOrigin> origins;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      origins.push_back({static_cast<int>(i), scene.bodies[i] != surfaces_[i]});
      bodies_[i].surface = scene.bodies[i].get();
      bodies_[i].previous = bodies_[i].current;
      bodies_[i].update();
    }
    surfaces_.assign(scene.bodies.begin(), scene.bodies.end());
    (void)reprojectContact(contact_, bodies_, origins);
  }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      bodies_[i].previous = bodies_[i].current;
      bodies_[i].current = poses[i];
      bodies_[i].update();
    }
    ContactResult contact;
    followGuarded(bodies_, contact_, hip, contact, corrections_);
    return {contact.touching, contact.ihip, spring_N_per_m() * (contact.ihip - hip), contact.work.triangles};
  }

 private:
  Corrections corrections_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Body> bodies_;
  ContactState contact_;
};

template <const Corrections& kCorrections>
[[nodiscard]] std::unique_ptr<Renderer> oursUnder() {
  return std::make_unique<AblatedMethod>(kCorrections);
}

}  // namespace haptics::eval
