#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/state/record_chain.h"

// What the log's records say (state.proto).
namespace haptics {

/// Remembered edits go into a checkpoint up to this size: they spare reconnecting clients a snapshot, no more.
inline constexpr std::size_t kMaxResumeBytes = 4U << 20;

[[nodiscard]] std::string checkpointRecord(const SequencerState& state);
[[nodiscard]] std::string editRecord(const AcceptedEdit& edit);

/// Where a log stops making sense.
struct LogDamage {
  /// Its last record is incomplete, as a crash leaves it. No edit in it was answered, unless the disk had said that it
  /// held what it did not.
  bool torn = false;
  std::size_t offset = 0;   ///< First bad byte's record begins here.
  std::size_t dropped = 0;  ///< Bytes from there on.
  std::string reason;
};

/// What a log leads to.
struct SavedState {
  SequencerState state;
  RecordWriter writer;              ///< To go on after the last good record.
  std::optional<LogDamage> damage;  ///< The state is that before it.
};

/// Refused: bytes that do not begin with this version's head and a good checkpoint. Untrusted bytes are welcome.
[[nodiscard]] Result<SavedState> readLog(std::string_view log);
/// The same for a log whose beginning is damaged, with a copy of its head and checkpoint in their place: the hashes of
/// the edits tell whether it is one.
[[nodiscard]] Result<SavedState> readLogBehind(std::string_view beginning, std::string_view log);

}  // namespace haptics
