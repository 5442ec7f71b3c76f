#pragma once

#include <filesystem>
#include <memory>

#include "graphics_client/export/session_sink.h"

namespace haptics {

/// A line for each tick, behind one with the columns' names and units: "force.written.x [N]"; of a second hand
/// "second_hand.force.written.x [N]". Numbers are the shortest that read back to the same bits. Objects, edits and gaps are
/// not in it. Refused: a file that cannot be written.
[[nodiscard]] Result<std::unique_ptr<SessionSink>> makeCsvSink(const std::filesystem::path& file,
                                                               const SessionFacts& facts);

}  // namespace haptics
