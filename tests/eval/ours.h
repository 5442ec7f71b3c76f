#pragma once

#include <vector>

#include "haptic_server/servo/haptic_step.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// The production step: adoptScene() and hapticStep(), as the server's loop calls them.
class Ours final : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const Surface>> bodies, std::span<const Pose> poses, Vec3 hip) override;
  void place(Vec3 hip) override;
  void contactOnly() override { contactOnly_ = true; }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  [[nodiscard]] Felt step(Vec3 hip);

  StepConfig config_{.period_s = kPeriod_s, .maxForce_N = 1e9};
  ServoScene scene_;
  HapticState state_{config_};
  std::uint64_t tick_ = 0;
  bool contactOnly_ = false;
};

}  // namespace haptics::eval
