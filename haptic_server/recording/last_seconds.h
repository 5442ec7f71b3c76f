#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "haptic_server/recording/recording_quota.h"
#include "haptic_server/recording/recording_writer.h"

// A recording of what a flight ring holds: scenes, the state that the last seconds begin with, their ticks.
namespace haptics {

/// Adds the scenes from this one on (ServoScene::number), which the state has adopted.
using AddScenes = std::function<void(RecordingWriter& writer, std::uint64_t from)>;

struct RecordingPlace {
  std::filesystem::path folder;  ///< Made where there is none.
  RecordingQuota quota = {};
};

/// @param facts  Began and why are left to this.
/// @return The new file, with `why` in its name. Refused, without a file: a folder or file that cannot be written or for
/// which the quota leaves no room, a ring without ticks.
[[nodiscard]] Result<std::filesystem::path> recordLastSeconds(const RecordingPlace& place, std::string why,
                                                              RecordingFacts facts, FlightRing& ring,
                                                              const AddScenes& addScenes);

/// After a crash, in another process, of a ring that is let go of (FlightRing::releaseDeadWriter).
/// @param journal  Descriptor of the SceneJournal's memory.
[[nodiscard]] Result<std::filesystem::path> recordCrash(const RecordingPlace& place, FlightRing& ring, int journal);

}  // namespace haptics
