#pragma once

#include <cstddef>
#include <filesystem>

#include "common/error/error.h"

namespace haptics {

/// What recordings of the last seconds may take of a disk.
struct RecordingQuota {
  std::size_t most_bytes = std::size_t(1) << 30;  ///< All of a folder's together, but for the last one.
  std::size_t maxFiles = 100;
  /// Left to whoever else writes to that disk, the scene's journal first; of a small disk a tenth.
  std::size_t leave_bytes = std::size_t(64) << 20;
};

/// "flight-...", as the flight recorder names a recording; no other file is counted or removed.
[[nodiscard]] bool isFlightRecording(const std::filesystem::path& file);
/// Removes recordings, the oldest by name first, until the others are within the quota. The newest stays, and the
/// newest of a fault.
void rotateRecordings(const std::filesystem::path& folder, const RecordingQuota& quota);
/// Refused: also without the older recordings the disk has no more than what is to be left.
[[nodiscard]] Result<void> makeRoomForRecording(const std::filesystem::path& folder, const RecordingQuota& quota);

}  // namespace haptics
