#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "common/error/error.h"
#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/state/durable_file.h"
#include "haptic_server/state/saved_state.h"

namespace haptics {

/// A folder in which the scene outlives the server:
///
///   log               a checkpoint and the edits accepted since (record_chain.h, state.proto)
///   checkpoint        a copy of the log's beginning, without which all that follows would mean nothing
///   assets/<hash>     the meshes, fields, vertex values and moved vertices that the log names, canonical bytes
///   log.damaged-<n>   what was left of a log that had to be given up, for whoever wants to look into it
///   lock              held by the server that uses the folder
///
/// An edit is on the disk, its assets before it, when keep() returns. A log that has grown is replaced by a checkpoint;
/// the old one is there until the new one is durable. One thread.
class StateFolder final : public EditJournal {
 public:
  using Log = std::function<void(const std::string&)>;
  struct Opened;
  struct Options {
    Log info, warning;
    /// Bytes written since the last checkpoint, and in proportion to its size, that lead to the next one: more cost disk
    /// and time to start, fewer cost writing.
    std::size_t checkpointAfter_bytes = 16U << 20;
    static constexpr std::size_t kCheckpointAfterSizes = 2;
  };

  /// Makes the folder when there is none. The state has the epoch that the folder holds if nothing of the log was lost,
  /// else `freshEpoch`, so that clients who may have seen more start anew.
  /// Refused: a folder that cannot be written or that another server uses, a log of another version or whose beginning
  /// is damaged together with its copy.
  [[nodiscard]] static Result<Opened> open(const std::filesystem::path& folder, std::uint64_t freshEpoch,
                                           Options options);

  [[nodiscard]] Result<void> keep(const SequencerState& before, const Edits& edits, const Assets& assets) override;
  /// The bytes as they are in the file: to be compared with the hash.
  [[nodiscard]] Result<std::string> readAsset(const ContentHash& hash) const;

 private:
  struct AssetBytes {
    std::size_t named = 0;   // by the version
    std::size_t others = 0;  // in the folder
  };
  std::filesystem::path folder_;
  Options options_;
  FileHandle lock_;
  FileHandle log_;        // none: it is not known what is in the file, and only a new one can tell
  std::size_t size_ = 0;  // of the log, good records only
  RecordWriter writer_;
  std::unordered_set<ContentHash> stored_;  // assets that this process has made durable
  std::size_t written_ = 0;                 // log and assets, since the last checkpoint
  std::size_t nextCheckpoint_ = 0;          // when written_ has come so far
  bool failing_ = false;

  StateFolder(std::filesystem::path folder, Options options)
      : folder_(std::move(folder)), options_(std::move(options)) {}

  Result<SequencerState> load(std::uint64_t freshEpoch);
  Result<void> giveUpDamaged(std::string_view log, const LogDamage& damage);
  Result<void> checkpoint(const SequencerState& state);
  Result<void> tryToKeep(const SequencerState& before, const Edits& edits, const Assets& assets);
  Result<void> storeAsset(const Asset& asset);
  void planCheckpoint(std::size_t lastSize);
  void collectAssets(const SceneVersion& version);
  [[nodiscard]] AssetBytes assetBytes(const SceneVersion& version) const;
};

struct StateFolder::Opened {
  std::unique_ptr<StateFolder> folder;
  SequencerState state;
};

}  // namespace haptics
