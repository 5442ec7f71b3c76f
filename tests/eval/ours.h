#pragma once

#include <vector>

#include "haptic_server/servo/haptic_step.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// The production step: adoptScene() and hapticStep(), as the server's loop calls them. Bodies that a scene moves take
/// the place of what would move them there.
class Ours final : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const Surface>> bodies, std::span<const Pose> poses, Vec3 hip) override;
  void place(Vec3 hip) override;
  void contactOnly() override { contactOnly_ = true; }
  /// Removed objects stay until the contact on them has faded, as ServoSceneMaker keeps them.
  void edit(const EditedScene& scene, Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  void adopt();
  [[nodiscard]] Felt step(Vec3 hip);

  StepConfig config_{.period_s = kPeriod_s, .maxForce_N = 1e9};
  std::unique_ptr<const ServoScene> scene_;
  std::unique_ptr<const ServoScene> next_;  // until it is adopted
  std::vector<std::uint64_t> ids_;          // of the bodies in the order of `poses`
  std::vector<Pose> poses_;                 // of the last tick or edit
  HapticState state_{config_};
  std::uint64_t tick_ = 0;
  bool contactOnly_ = false;
};

}  // namespace haptics::eval
