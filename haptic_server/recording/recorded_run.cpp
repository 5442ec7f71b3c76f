#include "haptic_server/recording/recorded_run.h"

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

Result<std::unique_ptr<RecordedRun>> RecordedRun::open(std::string_view bytes, AssetStore& store) {
  auto reader = RecordingReader::open(bytes);
  if (!reader) return tl::unexpected(std::move(reader.error()));
  return std::unique_ptr<RecordedRun>(new RecordedRun(*std::move(reader), store));
}

Result<std::optional<RecordedRunTick>> RecordedRun::next() {
  while (ticks_.empty()) {
    const auto part = reader_.next();
    if (!part) return tl::unexpected(part.error());
    if (*part == nullptr) return std::nullopt;
    if (auto taken = take(**part); !taken) return tl::unexpected(std::move(taken.error()));
  }
  auto tick = tickFrom(ticks_.substr(0, kTickBytes));
  if (!tick) return tl::unexpected(tick.error());
  ticks_.remove_prefix(kTickBytes);
  if (!turns_.empty()) {
    takeTurn(turns_.substr(0, kTurnBytes), *tick);
    turns_.remove_prefix(kTurnBytes);
  }
  const std::uint64_t number = tick->input.tick;
  if (lastTick_ && number <= *lastTick_)
    return refused("ticks", "tick " + std::to_string(number) + " comes after tick " + std::to_string(*lastTick_));
  lastTick_ = number;
  const RemadeScene* given = tick->scene == 0 ? nullptr : find(tick->scene);
  if (tick->scene != 0 && given == nullptr) return unknownScene("ticks.scene", tick->scene);
  return RecordedRunTick{*tick, given};
}

const RemadeScene* RecordedRun::find(std::uint64_t number) const {
  const auto at = given_.find(number);
  return at == given_.end() ? nullptr : &at->second;
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
  given_.insert_or_assign(message.number(), *std::move(remade));
  ++scenesMade_;
  return {};
}

Result<void> RecordedRun::take(const v1::RecordedState& message) {
  if (lastTick_) return refused("state", "comes after the first tick");
  if (!reader_.sameLayout()) {
    return refused("state",
                   "was recorded by a build whose state looks different, and the recording begins with it; "
                   "replay it with that build");
  }
  RecordedBeginning begun;
  for (const auto& [field, number, scene] : {std::tuple{"state.scene", message.scene(), &begun.scene},
                                             std::tuple{"state.pending", message.pending(), &begun.pending}}) {
    if (number == 0) continue;
    const RemadeScene* remade = find(number);
    if (remade == nullptr) return unknownScene(field, number);
    *scene = remade->scene.get();
  }
  const ServoScene empty;
  auto state = stateFrom(message.image(), begun.scene != nullptr ? *begun.scene : empty, facts().config);
  if (!state) return tl::unexpected(std::move(state.error()));
  begun.state = *std::move(state);
  beginning_ = std::move(begun);
  return {};
}

Result<void> RecordedRun::take(const v1::RecordedTicks& message) {
  if (message.ticks().size() % kTickBytes != 0) return refused("ticks", "has a part of a tick");
  const std::size_t ticks = message.ticks().size() / kTickBytes;
  if (!message.turns().empty() && message.turns().size() != ticks * kTurnBytes)
    return refused("ticks.turns", "is not of as many ticks");
  ticks_ = message.ticks();
  turns_ = message.turns();
  return {};
}

}  // namespace haptics
