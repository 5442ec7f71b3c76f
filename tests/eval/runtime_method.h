#pragma once

#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// The production step: adoptScene() and hapticStep(), as the server's loop calls them. Bodies that a scene moves take
/// the place of what would move them there.
class RuntimeMethod : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override;
  void setSurfaceProperties(const FeltSurface& surface) override;
  void place(Vec3 hip) override;
  void contactOnly() override { contactOnly_ = true; }
  /// Removed objects stay until the contact on them has faded, and go with an edit after that, as ServoSceneBuilder
  /// keeps them.
  void edit(const EditedScene& scene, Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;
  Felt drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) override;
  [[nodiscard]] bool turnsMirroredOver() const override { return true; }
  [[nodiscard]] std::vector<Dent> dents(std::size_t body) const override;
  [[nodiscard]] double highestBulge_m(std::size_t body) const override;

 protected:
  StepConfig& config() noexcept { return config_; }
  /// Of all bodies from the next begin() on, whatever they are dressed with.
  void shade(const Shading& shading) { shading_ = shading; }
  void letGo(Vec3 hip) { haptics::resetContact(state_.contact, hip); }

 private:
  void adopt();
  [[nodiscard]] Felt step(Vec3 hip);
  [[nodiscard]] Felt feelContact(std::span<const Body> bodies, Vec3 hip);
  [[nodiscard]] ServoObject makeObject(std::uint64_t id, const std::shared_ptr<const CollisionMesh>& surface,
                                       const Pose& pose, double spring_N_per_m);
  [[nodiscard]] std::shared_ptr<const SurfaceDetail> detailOf(const std::shared_ptr<const CollisionMesh>& surface);

  StepConfig config_{.period_s = kPeriod_s, .maxForce_N = 1e9};
  std::optional<FeltSurface> surface_;
  std::shared_ptr<const SoftTissue> tissue_;  // surface_'s
  std::optional<Shading> shading_;
  std::map<std::shared_ptr<const CollisionMesh>, std::shared_ptr<const SurfaceDetail>> details_;  // as dressed
  std::unique_ptr<const ServoScene> scene_;
  std::unique_ptr<const ServoScene> next_;            // until it is adopted
  std::vector<std::uint64_t> ids_;                    // of the bodies in the order of `poses`
  std::map<std::uint64_t, std::uint64_t> removedAt_;  // tick, by id
  std::vector<Pose> poses_;                           // of the last tick or edit
  std::uint64_t samples_ = 0;                         // that have come
  HapticState state_{config_};
  std::uint64_t tick_ = 0;
  bool contactOnly_ = false;
};

/// With force shading (paper 4.1) on every body; lines of more than 60 degrees stay sharp.
class ShadedMethod final : public RuntimeMethod {
 public:
  ShadedMethod() { shade({std::numbers::pi / 3, {}}); }
};

/// What is driven is at its last sample, and there at once.
class MethodThatHoldsSamples final : public RuntimeMethod {
 public:
  Felt drive(std::span<const Pose> samples, bool /*haveCome*/, Vec3 hip) override { return tick(samples, hip); }
};

/// An edit of what is touched lets go of the contact, and it begins anew from the HIP.
class MethodThatAttachesAnew final : public RuntimeMethod {
 public:
  void edit(const EditedScene& scene, Vec3 hip) override {
    RuntimeMethod::edit(scene, hip);
    letGo(hip);
  }
};

/// Mirrored triangles stay as they are.
class MethodThatTurnsNothingOver final : public RuntimeMethod {
 public:
  [[nodiscard]] bool turnsMirroredOver() const override { return false; }
};

/// Bodies that are put into each other are taken for apart.
class MethodThatOverlooksPutBodies final : public RuntimeMethod {
 public:
  [[nodiscard]] std::unique_ptr<BodyWorld> makeBodyWorld() const override;
};

/// K of Eq. (4) as it was set, whatever the device can bear.
class MethodWithoutGainClamp final : public RuntimeMethod {
 public:
  void setSurfaceProperties(const FeltSurface& surface) override {
    RuntimeMethod::setSurfaceProperties(surface);
    config().stableLateral_N_per_m = std::numeric_limits<double>::infinity();
  }
};

}  // namespace haptics::eval
