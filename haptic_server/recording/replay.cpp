#include "haptic_server/recording/replay.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "haptic_server/recording/recorded_run.h"
#include "haptic_server/step/moving_bodies.h"
#include "haptic_server/step/soft_bodies.h"
#include "haptic_server/step/tool_step.h"

namespace haptics {
namespace {

/// The servo of a recording, in its own time.
class ReplayedServo {
 public:
  ReplayedServo(RecordedRun& run, ReplayOutcome& outcome, const OnReplayedTick& onTick)
      : run_(run), outcome_(outcome), onTick_(onTick), state_(std::make_unique<HapticState>(outcome.facts.config)) {}

  /// False: it is to end.
  [[nodiscard]] bool take(const RecordedRunTick& tick) {
    if (outcome_.ticks == 0) begin();
    const StepInput& input = tick.recorded.input;
    if (tick.given != nullptr) next_ = tick.given->scene.get();
    if (next_ != nullptr && adoptScene(*next_, *state_, input.tick)) {
      scene_ = std::exchange(next_, nullptr);
      run_.letGoBefore(scene_->number);
    }
    const TelemetrySample sample = hapticStep(*scene_, *state_, outcome_.facts.config, input);
    account(tick.recorded, sample);
    if (!onTick_) return true;
    const bool moved = describeMotion(*state_, input.tick, motion_);
    const bool gave = describeDents(*state_, input.tick, motion_);
    return onTick_({sample, moved || gave ? &motion_ : nullptr, run_.find(scene_->number), run_.share()});
  }

 private:
  void begin() {
    RecordedBeginning& beginning = run_.beginning();
    if (!beginning.state) return;
    state_ = std::move(beginning.state);
    if (beginning.scene != nullptr) scene_ = beginning.scene;
    next_ = beginning.pending;
  }

  void account(const RecordedTick& recorded, const TelemetrySample& sample) {
    const Vec3 torque_Nm = writtenTorque_Nm(*state_);
    if (!sameBits(recorded.force_N, sample.force.written) || !sameBits(recorded.torque_Nm, torque_Nm)) {
      ++outcome_.differing;
      const ForceDifference difference{outcome_.ticks, recorded.input.tick, recorded.force_N, sample.force.written};
      if (!outcome_.first) outcome_.first = difference;
      outcome_.largestDifference_N =
          std::max(outcome_.largestDifference_N, glm::distance(difference.recorded_N, difference.now_N));
      outcome_.largestDifference_Nm =
          std::max(outcome_.largestDifference_Nm, glm::distance(recorded.torque_Nm, torque_Nm));
    }
    if (outcome_.ticks != 0) outcome_.missed += recorded.input.tick - lastTick_ - 1;
    if (sample.object != 0) ++outcome_.contactTicks;
    lastTick_ = recorded.input.tick;
    ++outcome_.ticks;
  }

  RecordedRun& run_;
  ReplayOutcome& outcome_;
  const OnReplayedTick& onTick_;
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;
  std::unique_ptr<HapticState> state_;
  MotionState motion_;
  std::uint64_t lastTick_ = 0;
};

}  // namespace

Result<ReplayOutcome> replay(std::string_view recording, const OnReplayedTick& onTick) {
  AssetStore store;
  const auto opened = RecordedRun::open(recording, store);
  if (!opened) return tl::unexpected(opened.error());
  RecordedRun& run = **opened;
  ReplayOutcome outcome;
  outcome.facts = run.facts();
  outcome.sameStep = run.sameStep();
  ReplayedServo servo(run, outcome, onTick);
  auto tick = run.next();
  while (tick && *tick && servo.take(**tick)) tick = run.next();
  outcome.scenes = run.scenes();
  outcome.cutOff = tick && !*tick && run.cutOff();
  if (!tick) outcome.refusal = tick.error();
  return outcome;
}

}  // namespace haptics
