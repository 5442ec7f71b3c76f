#include "haptic_server/recording/replay.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "haptic_server/recording/recorded_run.h"
#include "haptic_server/step/moving_bodies.h"
#include "haptic_server/step/soft_bodies.h"
#include "haptic_server/step/tool_step.h"
#include "haptic_server/step/two_hands.h"

namespace haptics {
namespace {

/// A hand of a recording, in its own time.
class ReplayedHand {
 public:
  explicit ReplayedHand(const StepConfig& config) : config_(config), state_(std::make_unique<HapticState>(config)) {}

  void begin(RecordedBeginning& beginning) {
    if (!beginning.state) return;
    state_ = std::move(beginning.state);
    if (beginning.scene != nullptr) scene_ = beginning.scene;
    next_ = beginning.pending;
  }
  void followFirst() { followFirstHand(*state_); }
  void adopt(const RemadeScene* given, std::uint64_t tick) {
    if (given != nullptr) next_ = given->scene.get();
    if (next_ != nullptr && adoptScene(*next_, *state_, tick)) scene_ = std::exchange(next_, nullptr);
  }
  [[nodiscard]] HandTick feel(const StepInput& input) {
    result_ = {};
    computeForce(*scene_, *state_, config_, input, result_);
    return {*scene_, *state_, config_, input, result_};
  }
  /// Null: as at the last call.
  [[nodiscard]] const MotionState* describe(std::uint64_t tick) {
    const bool moved = describeMotion(*state_, tick, motion_);
    const bool gave = describeDents(*state_, tick, motion_);
    return moved || gave ? &motion_ : nullptr;
  }
  [[nodiscard]] const MotionState& motion() const { return motion_; }
  [[nodiscard]] const ServoScene& scene() const { return *scene_; }
  [[nodiscard]] Vec3 torque_Nm() const { return writtenTorque_Nm(*state_); }

 private:
  const StepConfig& config_;
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;
  std::unique_ptr<HapticState> state_;
  ForceResult result_;
  MotionState motion_;
};

/// The servo of a recording.
class ReplayedServo {
 public:
  ReplayedServo(RecordedRun& run, ReplayOutcome& outcome, const OnReplayedTick& onTick)
      : run_(run), outcome_(outcome), onTick_(onTick), first_(outcome.facts.config) {
    if (!outcome.facts.secondHand) return;
    second_.emplace(outcome.facts.secondHand->config);
    second_->followFirst();
  }

  /// False: it is to end.
  [[nodiscard]] bool take(const RecordedRunTick& tick) {
    if (outcome_.ticks == 0) {
      first_.begin(run_.beginning());
      if (second_) second_->begin(run_.beginning(1));
    }
    const std::uint64_t number = tick.recorded[0].input.tick;
    first_.adopt(tick.given, number);
    if (second_) second_->adopt(tick.given, number);
    run_.letGoBefore(second_ ? std::min(first_.scene().number, second_->scene().number) : first_.scene().number);
    TelemetrySample sample, secondSample;
    const HandTick ticked = first_.feel(tick.recorded[0].input);
    if (second_) {
      finishSteps(ticked, second_->feel(tick.recorded[1].input), sample, secondSample);
    } else {
      sample = finishStep(ticked.scene, ticked.state, ticked.config, ticked.input, ticked.result);
    }
    const bool isSame = compare(tick.recorded[0], sample.force.written, first_.torque_Nm());
    const bool isSecondSame = !second_ || compare(tick.recorded[1], secondSample.force.written, second_->torque_Nm());
    if (!isSame || !isSecondSame) ++outcome_.differing;
    account(number, sample);
    if (!onTick_) return true;
    return onTick_(
        {sample, describe(number), second_ ? &secondSample : nullptr, run_.find(first_.scene().number), run_.share()});
  }

 private:
  [[nodiscard]] bool compare(const RecordedTick& recorded, Vec3 force_N, Vec3 torque_Nm) {
    if (sameBits(recorded.force_N, force_N) && sameBits(recorded.torque_Nm, torque_Nm)) return true;
    const ReplayDifference difference{outcome_.ticks, recorded.input.tick, recorded.force_N, force_N};
    if (!outcome_.first) outcome_.first = difference;
    outcome_.largestDifference_N =
        std::max(outcome_.largestDifference_N, glm::distance(difference.recorded_N, difference.now_N));
    outcome_.largestDifference_Nm =
        std::max(outcome_.largestDifference_Nm, glm::distance(recorded.torque_Nm, torque_Nm));
    return false;
  }

  [[nodiscard]] const MotionState* describe(std::uint64_t tick) {
    const MotionState* motion = first_.describe(tick);
    if (!second_) return motion;
    if (second_->describe(tick) == nullptr && motion == nullptr) return nullptr;
    motion_ = ofBothHands(first_.motion(), second_->motion());
    return &motion_;
  }

  void account(std::uint64_t tick, const TelemetrySample& sample) {
    if (outcome_.ticks != 0) outcome_.missed += tick - lastTick_ - 1;
    if (sample.object != 0) ++outcome_.contactTicks;
    lastTick_ = tick;
    ++outcome_.ticks;
  }

  RecordedRun& run_;
  ReplayOutcome& outcome_;
  const OnReplayedTick& onTick_;
  ReplayedHand first_;
  std::optional<ReplayedHand> second_;
  MotionState motion_;  // of both
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
