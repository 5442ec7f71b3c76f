#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/recording/recorded_scenes.h"
#include "haptic_server/recording/recording_reader.h"

namespace haptics {

/// A state that a recording holds, of one hand.
struct RecordedBeginning {
  const ServoScene* scene = nullptr;    ///< That the state had adopted; null: the empty one.
  const ServoScene* pending = nullptr;  ///< That it was still to adopt; null: none.
  std::unique_ptr<HapticState> state;   ///< Null: as a server starts.
};

using RecordedBeginnings = std::array<RecordedBeginning, kMaxHands>;

struct RecordedRunTick {
  std::array<RecordedTick, kMaxHands> recorded;  ///< Of each hand.
  const RemadeScene* given = nullptr;            ///< What came at its start; null: no scene did.
};

/// Takes a recording in order and makes what the servo computed with again: scenes, the state that it begins with, ticks.
/// Untrusted bytes are welcome.
class RecordedRun {
 public:
  /// The store outlives it. Refused: no recording of this version.
  [[nodiscard]] static Result<std::unique_ptr<RecordedRun>> open(RecordingBytes bytes, AssetStore& store);
  /// The store outlives it.
  RecordedRun(std::unique_ptr<RecordingSource> source, AssetStore& store)
      : source_(std::move(source)), scenes_(store, source_->facts()) {}

  [[nodiscard]] const RecordingFacts& facts() const noexcept { return source_->facts(); }
  /// The step's sources are those that made the recording.
  [[nodiscard]] bool sameStep() const noexcept { return facts().stepSources == ownStepSources(); }

  /// Nothing at the end. Refused: what the recording cannot be followed beyond.
  [[nodiscard]] Result<std::optional<RecordedRunTick>> next();
  /// Once next() was called.
  [[nodiscard]] RecordedBeginnings& beginnings() noexcept { return beginnings_; }
  /// The state that lies before the tick that next() gave last; null: none does, or this build's states look different.
  [[nodiscard]] const v1::RecordedState* keyframe() const noexcept { return keyframe_ ? &*keyframe_ : nullptr; }
  /// Refused: no state of its scene.
  [[nodiscard]] Result<RecordedBeginnings> beginningsAt(const v1::RecordedState& keyframe) const;
  /// Null when it is not there, or was let go.
  [[nodiscard]] const RemadeScene* find(std::uint64_t number) const;
  /// That were not let go.
  [[nodiscard]] std::vector<std::shared_ptr<const RemadeScene>> heldScenes() const;
  /// Releases the scenes before this one (ServoScene::number): none is in use any more.
  void releaseBefore(std::uint64_t number) { given_.erase(given_.begin(), given_.lower_bound(number)); }

  [[nodiscard]] double share() const noexcept { return source_->share(); }  ///< Of the bytes that were read.
  [[nodiscard]] std::uint64_t scenes() const noexcept { return scenesMade_; }
  /// Once next() has returned nothing: the last part was being written when the server ended.
  [[nodiscard]] bool cutOff() const noexcept { return source_->cutOff(); }

 private:
  [[nodiscard]] Result<void> take(const v1::RecordingPart& part);
  [[nodiscard]] Result<void> take(const v1::RecordedScene& message);
  [[nodiscard]] Result<void> take(const v1::RecordedState& message);
  [[nodiscard]] Result<RecordedBeginning> beginningFrom(const v1::RecordedState& message, std::size_t hand) const;
  [[nodiscard]] Result<void> take(const v1::RecordedTicks& message);
  [[nodiscard]] Result<RecordedTick> nextOf(std::size_t hand);

  std::unique_ptr<RecordingSource> source_;
  RecordedScenes scenes_;
  std::map<std::uint64_t, std::shared_ptr<const RemadeScene>> given_;  // that may still be used, by number
  RecordedBeginnings beginnings_;
  std::optional<v1::RecordedState> keyframe_;
  std::uint64_t scenesMade_ = 0;
  struct Left {
    std::string_view ticks, turns, handles, wrenches, grips;
  };
  std::array<Left, kMaxHands> left_;  // of the part last read
  std::optional<std::uint64_t> lastTick_;
  std::uint64_t lastGiven_ = 0;  // scene
};

}  // namespace haptics
