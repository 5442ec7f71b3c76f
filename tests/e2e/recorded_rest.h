#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "haptic_server/recording/recording_bytes.h"
#include "tests/e2e/fuzzed_edits.h"

namespace haptics::e2e {

/// What a client sent while the HIP rested, and when all of it is to be felt in full.
struct SentWindow {
  const FuzzedEdits* from = nullptr;
  std::size_t window = 0;
  std::uint64_t revision = 0;    ///< Of the last of its edits.
  std::uint64_t settled_ns = 0;  ///< Monotonic clock.
};

struct RestVerdict {
  std::uint64_t ticks = 0;      ///< In the recording,
  std::uint64_t resting = 0;    ///< and those of them that were judged,
  std::uint64_t missed = 0;     ///< and between them.
  std::uint64_t differing = 0;  ///< Whose force does not come out as recorded.
  std::uint64_t faults = 0;     ///< In which a fault took the force away.
  std::uint64_t settled = 0;    ///< Windows that were judged when they are to be felt in full,
  std::uint64_t inContact = 0;  ///< with an object at the HIP,
  std::uint64_t exact = 0;      ///< and of which the spring was compared too.
  double largestStep_N = 0;     ///< From tick to tick, per period, while the HIP rests.
  std::vector<std::string> failures;
};

/// Replays a recording and judges the written force wherever the HIP has rested for a while: it changes by no more than the
/// limit of the fuzzer a tick, across missed ticks as often as there are periods. When a window of edits is to be felt in
/// full, its revision is adopted, the force is the one that the scene's own parameters say, and the IHIP is in no closed
/// body. A fault, as of a machine that is too busy, is none of the edits': until the force has come back nothing is judged.
[[nodiscard]] RestVerdict judgeRest(const RecordingBytes& recording, const std::vector<SentWindow>& windows);

}  // namespace haptics::e2e
