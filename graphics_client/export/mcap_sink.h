#pragma once

#include <filesystem>
#include <memory>

#include "graphics_client/export/session_sink.h"

namespace haptics {

/// Protobuf messages with their descriptors, each at the time of its tick (Unix time):
///
///     /telemetry  haptics.v1.Telemetry        every tick, as the protocol has it
///     /scene      haptics.v1.SnapshotObjects  the objects' records, at each revision
///     /assets     haptics.v1.RecordedAsset    their meshes, before
///     /tf         foxglove.FrameTransform     a frame for each object, where it is, at most kShown_Hz
///     /objects    foxglove.SceneUpdate        their triangles, in these frames
///     /hand       foxglove.SceneUpdate        HIP, IHIP and force, at most kShown_Hz
///
/// Gaps and what a recording's end says are metadata of the name "session". Refused: a file that cannot be written.
[[nodiscard]] Result<std::unique_ptr<SessionSink>> makeMcapSink(const std::filesystem::path& file,
                                                                const SessionFacts& facts);

}  // namespace haptics
