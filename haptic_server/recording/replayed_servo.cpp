#include "haptic_server/recording/replayed_servo.h"

#include <algorithm>
#include <span>
#include <utility>

#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "haptic_server/engine/step/tool_step.h"
#include "haptic_server/engine/step/two_hands.h"

namespace haptics {

ReplayedHand::ReplayedHand(const StepConfig& config)
    : config_(config), scene_(std::make_shared<const ServoScene>()), state_(std::make_unique<HapticState>(config)) {}

void ReplayedHand::begin(const RecordedBeginning& beginning) {
  if (!beginning.state) return;
  *state_ = *beginning.state;
  if (beginning.scene != nullptr) scene_ = own(beginning.scene);
  if (scene_->anyReshaped()) static_cast<void>(state_->connect(*scene_));  // as it was with the one that it is made of
  if (beginning.pending != nullptr) next_ = own(beginning.pending);
}

std::shared_ptr<const ServoScene> ReplayedHand::own(const ServoScene* scene) {
  if (!scene->anyReshaped()) return {std::shared_ptr<const ServoScene>(), scene};  // outlives this
  std::erase_if(shapes_, [](const auto& entry) { return entry.second.use_count() == 1; });
  auto copy = std::make_shared<ServoScene>(*scene);
  for (std::size_t i = 0; i < copy->shapes.size(); ++i) {
    KinematicShape& shape = copy->shapes[i];
    for (std::shared_ptr<ShapeMemory>& memory : shape.memory) {
      if (!memory) continue;
      std::shared_ptr<ShapeMemory>& mine = shapes_[memory];
      const std::size_t vertices = shape.samples.fromOldest.back()->size();
      if (!mine) mine = std::make_shared<ShapeMemory>(*copy->objects[i].surface, vertices);
      memory = mine;
    }
  }
  return copy;
}

void ReplayedHand::adopt(const RemadeScene* given, std::uint64_t tick) {
  if (given != nullptr) next_ = own(given->scene.get());
  if (next_ && adoptScene(*next_, *state_, tick)) scene_ = std::exchange(next_, nullptr);
}

HandTick ReplayedHand::feel(const RecordedTick& tick) {
  result_ = {};
  if (const AddedWrench added(tick.added); added.acts) result_.add(added.force_N);
  computeForce(*scene_, *state_, config_, tick.input, result_);
  return {*scene_, *state_, config_, tick.input, result_};
}

Vec3 ReplayedHand::torque_Nm(const RecordedTick& tick) const noexcept {
  return writtenTorque_Nm(*state_, config_, AddedWrench(tick.added));
}

const MotionState* ReplayedHand::motionIfChanged(std::uint64_t tick) {
  const bool moved = updateMotionState(*state_, tick, motion_);
  const bool gave = updateDentsState(*state_, tick, motion_);
  return moved || gave ? &motion_ : nullptr;
}

std::string ReplayedHand::differenceFrom(const RecordedBeginning& recorded) const {
  const auto numberOf = [](const ServoScene* scene) { return scene != nullptr ? scene->number : 0; };
  const bool sameScenes =
      scene_->number == numberOf(recorded.scene) && numberOf(next_.get()) == numberOf(recorded.pending);
  return sameScenes ? firstDifference<StateFields>(*state_, *recorded.state) : "scene";
}

ReplayedServo::ReplayedServo(const RecordingFacts& facts) : first_(facts.config) {
  if (!facts.secondHand) return;
  second_.emplace(facts.secondHand->config);
  followFirstHand(second_->state());
}

void ReplayedServo::begin(const RecordedBeginnings& beginnings) {
  first_.begin(beginnings[0]);
  if (second_) second_->begin(beginnings[1]);
}

ReplayedServo::Tick ReplayedServo::take(const RecordedRunTick& tick) {
  const std::uint64_t number = tick.recorded[0].input.tick;
  first_.adopt(tick.given, number);
  if (second_) second_->adopt(tick.given, number);
  Tick made;
  const HandTick ticked = first_.feel(tick.recorded[0]);
  if (second_) {
    finishSteps(ticked, second_->feel(tick.recorded[1]), made.sample, made.secondSample);
    made.secondSample.handle = tick.recorded[1].handle;
    made.torque_Nm[1] = second_->torque_Nm(tick.recorded[1]);
    made.grip_Nm[1] = writtenGrip_Nm(second_->state());
  } else {
    made.sample = finishStep(ticked.scene, ticked.state, ticked.config, ticked.input, ticked.result);
  }
  made.sample.handle = tick.recorded[0].handle;
  made.torque_Nm[0] = first_.torque_Nm(tick.recorded[0]);
  made.grip_Nm[0] = writtenGrip_Nm(first_.state());
  return made;
}

const MotionState* ReplayedServo::motionIfChanged(std::uint64_t tick) {
  const MotionState* motion = first_.motionIfChanged(tick);
  if (!second_) return motion;
  if (second_->motionIfChanged(tick) == nullptr && motion == nullptr) return nullptr;
  motion_ = ofBothHands(first_.motion(), second_->motion());
  return &motion_;
}

std::uint64_t ReplayedServo::oldestScene() const noexcept {
  return second_ ? std::min(first_.scene(), second_->scene()) : first_.scene();
}

std::string ReplayedServo::differenceFrom(const RecordedBeginnings& recorded) const {
  const std::string first = first_.differenceFrom(recorded[0]);
  return first.empty() && second_ ? second_->differenceFrom(recorded[1]) : first;
}

}  // namespace haptics
