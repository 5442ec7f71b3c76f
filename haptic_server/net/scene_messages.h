#pragma once

#include <cstddef>
#include <cstdint>

#include "common/scene/scene.h"
#include "haptic_server/scene/scene_history.h"
#include "haptic_server/scene/sequencer.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// Bytes of a frame around the objects: envelope, numbers, roots and a reason.
inline constexpr std::size_t kAroundObjects_bytes = 1536;

/// The outcome of an edit, in at most frame_bytes with its envelope: of an accepted edit that was made under other
/// limits, revision and root only; of a conflict's objects as many as fit; the beginning of a long reason.
void toWire(const EditOutcome& outcome, std::size_t frame_bytes, v1::EditReply& reply);

/// Whether the commits that lead from this revision to the newest fit a frame each.
[[nodiscard]] bool fitFrames(const SceneHistory& history, std::uint64_t revision, std::size_t frame_bytes);

}  // namespace haptics
