#include "haptic_server/recording/recorded_run.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "haptic_server/recording/state_image.h"

namespace haptics {
namespace {

[[nodiscard]] tl::unexpected<Error> unknownScene(const char* field, std::uint64_t number) {
  return refused(field, "names scene " + std::to_string(number) + ", which is not there, or was left behind");
}

}  // namespace

Result<std::unique_ptr<RecordedRun>> RecordedRun::open(RecordingBytes bytes, AssetStore& store) {
  auto reader = RecordingReader::open(std::move(bytes));
  if (!reader) return tl::unexpected(std::move(reader.error()));
  return std::make_unique<RecordedRun>(std::make_unique<RecordingReader>(*std::move(reader)), store);
}

Result<std::optional<RecordedRunTick>> RecordedRun::next() {
  keyframe_.reset();
  while (left_[0].ticks.empty()) {
    const auto part = source_->next();
    if (!part) return tl::unexpected(part.error());
    if (*part == nullptr) return std::nullopt;
    if (auto taken = take(**part); !taken) return tl::unexpected(std::move(taken.error()));
  }
  RecordedRunTick next;
  for (std::size_t hand = 0; hand < facts().hands(); ++hand) {
    auto tick = nextOf(hand);
    if (!tick) return tl::unexpected(std::move(tick.error()));
    next.recorded[hand] = *tick;
  }
  const RecordedTick& first = next.recorded[0];
  const std::uint64_t number = first.input.tick;
  if (facts().secondHand && next.recorded[1].input.tick != number)
    return refused("ticks.second_hand", "has tick " + std::to_string(next.recorded[1].input.tick) +
                                            " where the first hand has tick " + std::to_string(number));
  if (lastTick_ && number <= *lastTick_)
    return refused("ticks", "tick " + std::to_string(number) + " comes after tick " + std::to_string(*lastTick_));
  lastTick_ = number;
  if (first.scene == 0) return next;
  if (first.scene <= lastGiven_)
    return refused("ticks.scene", std::to_string(first.scene) + " comes after " + std::to_string(lastGiven_));
  lastGiven_ = first.scene;
  next.given = find(first.scene);
  if (next.given == nullptr) return unknownScene("ticks.scene", first.scene);
  return next;
}

Result<RecordedTick> RecordedRun::nextOf(std::size_t hand) {
  Left& left = left_[hand];
  auto tick = tickFrom(left.ticks.substr(0, kTickBytes));
  if (!tick) return tick;
  left.ticks.remove_prefix(kTickBytes);
  if (!left.turns.empty()) {
    takeTurn(left.turns.substr(0, kTurnBytes), *tick);
    left.turns.remove_prefix(kTurnBytes);
  }
  if (!left.wrenches.empty()) {
    tick->added = wrenchFrom(left.wrenches.substr(0, kWrenchBytes));
    left.wrenches.remove_prefix(kWrenchBytes);
  }
  if (!left.grips.empty()) {
    tick->grip_Nm = gripFrom(left.grips.substr(0, kGripBytes));
    left.grips.remove_prefix(kGripBytes);
  }
  if (left.handles.empty()) return tick;
  const auto handle = handleFrom(left.handles.substr(0, kHandleBytes));
  if (!handle) return tl::unexpected(handle.error());
  tick->handle = *handle;
  if (handle->has(HandleReading::kGripper)) tick->input.device.gripper_rad = handle->gripper_rad;
  left.handles.remove_prefix(kHandleBytes);
  return tick;
}

const RemadeScene* RecordedRun::find(std::uint64_t number) const {
  const auto at = given_.find(number);
  return at == given_.end() ? nullptr : at->second.get();
}

std::vector<std::shared_ptr<const RemadeScene>> RecordedRun::heldScenes() const {
  std::vector<std::shared_ptr<const RemadeScene>> held;
  for (const auto& [number, scene] : given_) held.push_back(scene);
  return held;
}

Result<void> RecordedRun::take(const v1::RecordingPart& part) {
  switch (part.part_case()) {
    case v1::RecordingPart::kAsset:
      return scenes_.add(part.asset());
    case v1::RecordingPart::kScene:
      return take(part.scene());
    case v1::RecordingPart::kState:
      return take(part.state());
    case v1::RecordingPart::kTicks:
      return take(part.ticks());
    default:
      return refused("head", "comes a second time");
  }
}

Result<void> RecordedRun::take(const v1::RecordedScene& message) {
  auto remade = scenes_.make(message);
  if (!remade) return tl::unexpected(std::move(remade.error()));
  given_.insert_or_assign(message.number(), std::make_shared<const RemadeScene>(*std::move(remade)));
  ++scenesMade_;
  return {};
}

Result<void> RecordedRun::take(const v1::RecordedState& message) {
  if (lastTick_) {
    if (source_->sameLayout()) keyframe_ = message;
    return {};
  }
  if (!source_->sameLayout()) {
    return refused("state",
                   "was recorded by a build whose state looks different, and the recording begins with it; "
                   "replay it with that build");
  }
  auto beginnings = beginningsAt(message);
  if (!beginnings) return tl::unexpected(std::move(beginnings.error()));
  beginnings_ = *std::move(beginnings);
  for (const RecordedBeginning& begun : beginnings_) {
    for (const ServoScene* scene : {begun.scene, begun.pending})
      lastGiven_ = std::max(lastGiven_, scene != nullptr ? scene->number : 0);
  }
  return {};
}

Result<RecordedBeginnings> RecordedRun::beginningsAt(const v1::RecordedState& keyframe) const {
  if (keyframe.has_second_hand() != facts().secondHand.has_value())
    return refused("state.second_hand", "does not go with the hands that the head names");
  RecordedBeginnings beginnings;
  const v1::RecordedState* ofHand = &keyframe;
  for (std::size_t hand = 0; hand < facts().hands(); ++hand) {
    auto begun = beginningFrom(*ofHand, hand);
    if (!begun) return tl::unexpected(std::move(begun.error()));
    beginnings[hand] = *std::move(begun);
    ofHand = &keyframe.second_hand();
  }
  return beginnings;
}

Result<RecordedBeginning> RecordedRun::beginningFrom(const v1::RecordedState& message, std::size_t hand) const {
  RecordedBeginning begun;
  if (message.pending() != 0 && message.pending() <= message.scene())
    return refused("state.pending", "is scene " + std::to_string(message.pending()) + ", which does not come after " +
                                        std::to_string(message.scene()));
  for (const auto& [field, number, scene] : {std::tuple{"state.scene", message.scene(), &begun.scene},
                                             std::tuple{"state.pending", message.pending(), &begun.pending}}) {
    if (number == 0) continue;
    const RemadeScene* remade = find(number);
    if (remade == nullptr) return unknownScene(field, number);
    *scene = remade->scene.get();
  }
  static const ServoScene empty;
  const StepConfig& config = hand == 0 ? facts().config : facts().secondHand->config;
  auto state = stateFrom(message.image(), begun.scene != nullptr ? *begun.scene : empty, config);
  if (!state) return tl::unexpected(std::move(state.error()));
  if ((*state)->motion.follows != (hand == 1)) return refused("state.image", "is that of the other hand");
  begun.state = *std::move(state);
  return begun;
}

Result<void> RecordedRun::take(const v1::RecordedTicks& message) {
  if (message.has_second_hand() != facts().secondHand.has_value())
    return refused("ticks.second_hand", "does not go with the hands that the head names");
  const std::size_t ticks = message.ticks().size() / kTickBytes;
  const v1::RecordedTicks* ofHand = &message;
  for (std::size_t hand = 0; hand < facts().hands(); ++hand) {
    if (ofHand->ticks().size() % kTickBytes != 0) return refused("ticks", "has a part of a tick");
    if (ofHand->ticks().size() != ticks * kTickBytes) return refused("ticks.second_hand", "is not as many ticks");
    if (!ofHand->turns().empty() && ofHand->turns().size() != ticks * kTurnBytes)
      return refused("ticks.turns", "is not of as many ticks");
    if (!ofHand->handles().empty() && ofHand->handles().size() != ticks * kHandleBytes)
      return refused("ticks.handles", "is not of as many ticks");
    if (!ofHand->wrenches().empty() && ofHand->wrenches().size() != ticks * kWrenchBytes)
      return refused("ticks.wrenches", "is not of as many ticks");
    if (!ofHand->grips().empty() && ofHand->grips().size() != ticks * kGripBytes)
      return refused("ticks.grips", "is not of as many ticks");
    left_[hand] = {ofHand->ticks(), ofHand->turns(), ofHand->handles(), ofHand->wrenches(), ofHand->grips()};
    ofHand = &message.second_hand();
  }
  return {};
}

}  // namespace haptics
