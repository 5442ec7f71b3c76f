#pragma once

#include <memory>
#include <optional>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/textures/texture_cases.h"

namespace haptics::eval {

/// How a specimen is felt.
struct Feel {
  double stiffness_N_per_m = 500;
  double damping_Ns_per_m = 0;
  StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9};
  Pose pose;  ///< Of the object in the world.
};

/// What one tick gave, in the object's frame.
struct Touch {
  bool touching = false;
  Vec3 ihip{0};           ///< m
  Vec3 normal{0};         ///< N_s
  double height_m = 0;    ///< h
  ForceComponents force;  ///< N
  FrictionState friction = FrictionState::kNone;
  Vec3 stickingPoint{0};  ///< m
};

/// One object under the production step, adoptScene() and hapticStep(), in virtual time. Places are in its own frame.
class TextureSample {
 public:
  TextureSample(std::shared_ptr<const CollisionMesh> surface, std::shared_ptr<const SurfaceDetail> detail,
                const Feel& feel);

  /// Attaches anew at a place outside.
  void place(Vec3 hip);
  Touch tick(Vec3 hip);
  /// Ticks of at most `step_m` along a straight line from the last place; calls check(touch, hip) after each.
  template <class Check>
  void lead(Vec3 to, double step_m, Check check) {
    const Vec3 from = hip_;
    const int ticks = std::max(1, static_cast<int>(std::ceil(glm::distance(from, to) / step_m)));
    for (int i = 1; i <= ticks; ++i) {
      const Vec3 hip = glm::mix(from, to, static_cast<double>(i) / ticks);
      check(tick(hip), hip);
    }
  }
  void lead(Vec3 to, double step_m) {
    lead(to, step_m, [](const Touch&, Vec3) {});
  }

 private:
  Feel feel_;
  ServoScene scene_;
  std::unique_ptr<HapticState> state_;
  std::uint64_t tick_ = 0;
  Vec3 hip_{0};
};

/// A plate of 120 mm x 120 mm with its upper side at z = 0.
[[nodiscard]] const TriMesh& boardMesh();
[[nodiscard]] std::shared_ptr<const CollisionMesh> boardSurface();
/// The board with properties, and the exhibits whose fields they name.
[[nodiscard]] std::shared_ptr<const SurfaceDetail> boardDetail(const SurfaceProperties& properties,
                                                               const TextureCase* texture,
                                                               const TextureCase* friction = nullptr);

}  // namespace haptics::eval
