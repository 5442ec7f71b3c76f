#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/recording/recorded_scenes.h"
#include "haptic_server/recording/recording_reader.h"

namespace haptics {

/// A tick of a hand that came to another force or torque than the one recorded.
struct ReplayDifference {
  std::uint64_t position = 0;  ///< In the recording, from 0.
  std::uint64_t tick = 0;
  Vec3 recorded_N{0};
  Vec3 now_N{0};
};

/// What came of ticks that were computed again.
struct ReplayCount {
  std::uint64_t ticks = 0;         ///< Ticks replayed.
  std::uint64_t missed = 0;        ///< Ticks between them that the servo slept through.
  std::uint64_t contactTicks = 0;  ///< Of the first hand.
  std::uint64_t differing = 0;     ///< Ticks whose force or torque, of any hand, differs in any bit.
  std::optional<ReplayDifference> first;
  double largestDifference_N = 0, largestDifference_Nm = 0;
};

struct ReplayOutcome : ReplayCount {
  RecordingFacts facts;
  std::uint64_t ticksAhead = 0;  ///< Of them computed ahead of those before them, from a state in the recording.
  /// States in the recording that are none, or that the ticks before did not come to, or from which those after went
  /// another way.
  std::uint64_t differingStates = 0;
  /// The first of them: the tick that follows it, and in which field it is another one.
  std::uint64_t firstDifferingState = 0;
  std::string differingField;
  bool sameStep = false;         ///< The step's sources are those that made the recording.
  std::uint64_t scenes = 0;      ///< That the servo was given.
  bool cutOff = false;           ///< The recording ends within a part, as it does when a server is killed.
  std::optional<Error> refusal;  ///< Why it was not replayed to its end.
};

/// Forces and states that came out otherwise, in words; empty: none did.
[[nodiscard]] std::string differenceIn(const ReplayOutcome& outcome);

/// A tick that was computed again. Valid during the call.
struct ReplayedTick {
  const TelemetrySample& sample;
  const MotionState* motion;            ///< Where the objects that move are, and all dents; null: as in the last call.
  const TelemetrySample* secondSample;  ///< Of the second hand; null: there is none.
  const RemadeScene* scene;             ///< That the servo had adopted; null: the empty one.
  double share;                         ///< Of the recording's bytes that were read, 0 to 1.
};

/// False ends the replay with this tick.
using OnReplayedTick = std::function<bool(const ReplayedTick&)>;

/// Runs the step over a recording as fast as it goes, with what the servo computed with, and compares the forces bit for
/// bit. Parts that begin with a state that the recording holds are computed on threads of their own, ahead of the parts
/// before them, and again where those do not come to that state. Untrusted bytes are welcome.
/// @param onTick  In order, on the calling thread.
/// Refused: no recording of this version.
[[nodiscard]] Result<ReplayOutcome> replay(RecordingBytes recording, const OnReplayedTick& onTick = {});
/// Likewise, of a recording whose parts may be coming yet.
/// @param onProgress  With what is replayed so far, after each part that begins with a state; false ends the replay.
[[nodiscard]] ReplayOutcome replay(std::unique_ptr<RecordingSource> recording,
                                   const std::function<bool(const ReplayOutcome&)>& onProgress);

}  // namespace haptics
