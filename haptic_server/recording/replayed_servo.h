#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/telemetry/motion_state.h"
#include "haptic_server/recording/recorded_run.h"

namespace haptics {

/// A hand of a recording, in its own time.
class ReplayedHand {
 public:
  /// As a server starts. The configuration outlives it.
  explicit ReplayedHand(const StepConfig& config);

  /// Goes on from a state of the recording, where it holds one.
  void begin(const RecordedBeginning& beginning);
  void adopt(const RemadeScene* given, std::uint64_t tick);
  /// @param tick  Stays until it is finished.
  [[nodiscard]] HandTick feel(const RecordedTick& tick);
  /// Null: as at the last call.
  [[nodiscard]] const MotionState* motionIfChanged(std::uint64_t tick);

  [[nodiscard]] HapticState& state() noexcept { return *state_; }
  /// As written to the device in this tick.
  [[nodiscard]] Vec3 torque_Nm(const RecordedTick& tick) const noexcept;
  [[nodiscard]] const MotionState& motion() const noexcept { return motion_; }
  /// ServoScene::number of the one adopted; 0: the empty one.
  [[nodiscard]] std::uint64_t scene() const noexcept { return scene_->number; }
  /// In what it differs from this state first: "scene", or a field, ".contact.ihip"; empty: in no bit.
  [[nodiscard]] std::string differenceFrom(const RecordedBeginning& recorded) const;

 private:
  /// With memory of its own for shapes that are driven: other hands may compute with the same scene.
  [[nodiscard]] std::shared_ptr<const ServoScene> own(const ServoScene* scene);

  const StepConfig& config_;
  std::map<std::shared_ptr<ShapeMemory>, std::shared_ptr<ShapeMemory>> shapes_;  // own ones, by the scenes'
  std::shared_ptr<const ServoScene> scene_, next_;
  std::unique_ptr<HapticState> state_;
  ForceResult result_;
  MotionState motion_;
};

/// The servo of a recording: computes its ticks again. The scenes that it is given outlive it.
class ReplayedServo {
 public:
  struct Tick {
    TelemetrySample sample, secondSample;
    std::array<Vec3, kMaxHands> torque_Nm;    ///< As written to each device,
    std::array<double, kMaxHands> grip_Nm{};  ///< and to its gripper.
  };

  /// The facts outlive it.
  explicit ReplayedServo(const RecordingFacts& facts);

  void begin(const RecordedBeginnings& beginnings);
  [[nodiscard]] Tick take(const RecordedRunTick& tick);
  /// Where the objects that move are, and all dents, after take(); null: as at the last call.
  [[nodiscard]] const MotionState* motionIfChanged(std::uint64_t tick);

  /// ServoScene::number of the first hand's; 0: the empty one.
  [[nodiscard]] std::uint64_t scene() const noexcept { return first_.scene(); }
  /// Scenes before this one are not in use any more.
  [[nodiscard]] std::uint64_t oldestScene() const noexcept;
  /// As ReplayedHand::differenceFrom(), of the hands in turn.
  [[nodiscard]] std::string differenceFrom(const RecordedBeginnings& recorded) const;

 private:
  ReplayedHand first_;
  std::optional<ReplayedHand> second_;
  MotionState motion_;  // of both
};

}  // namespace haptics
