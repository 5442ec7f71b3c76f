#pragma once

#include <filesystem>
#include <memory>

#include "graphics_client/export/session_sink.h"

namespace haptics {

/// One data set for each quantity, with attributes `units`, `frame` and `description`:
///
///     /                    attributes: source, server, device, rate, began, complete, note, ...
///     /ticks/...           a row for each tick: tick, time, hip, force/written, ... (tick_columns.cpp)
///     /second_hand/...     the same of a second hand
///     /bodies/...          rows: tick, object, position, rotation, condition; of a body that moved
///     /dents/...           rows: tick, object, centre, displacement; all that there are, whenever one has changed
///     /scenes/00000001     a revision: attributes root and first_tick, text; and the objects' records
///     /meshes/HASH         vertices and triangles
///     /edits, /faults, /gaps   rows
///
/// Refused: a file that cannot be written.
[[nodiscard]] Result<std::unique_ptr<SessionSink>> makeHdf5Sink(const std::filesystem::path& file,
                                                                const SessionFacts& facts);

}  // namespace haptics
