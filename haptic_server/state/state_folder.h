#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/state/asset_files.h"
#include "haptic_server/state/durable_file.h"
#include "haptic_server/state/saved_state.h"

namespace haptics {

/// A folder in which the scene outlives the server:
///
///   log                  a checkpoint and the edits accepted since (record_chain.h, state.proto)
///   checkpoint           a copy of the log's beginning, without which all that follows would mean nothing
///   assets/HASH          the meshes, fields, vertex values and moved vertices that the log names, canonical bytes
///   *.damaged-N          what had to be given up, as it was found at time N (Unix, seconds), for whoever wants to look
///                        into it; the assets of that time stay with it. Both for kKeepAside_s and up to a size
///   reserve              space for when the disk is full of something else
///   lock                 held by the server that uses the folder
///
/// An edit is on the disk, its assets before it, when keep() returns. A log that has grown is replaced by a checkpoint;
/// the old one is there until the new one is durable. One thread, but for what says otherwise.
class StateFolder final : public EditJournal {
 public:
  using Log = std::function<void(const std::string&)>;
  struct Opened;
  struct Options {
    Log info = [](const std::string&) {}, warning = info;
    /// Bytes written since the last checkpoint, and in proportion to its size, that lead to the next one: more cost disk
    /// and time to start, fewer cost writing.
    std::size_t checkpointAfter_bytes = 16U << 20;
    static constexpr std::size_t kCheckpointAfterSizes = 2;
    /// Given back when the disk is full: edits go on for so long, and there is time to see the warning.
    std::size_t reserve_bytes = 16U << 20;
    std::shared_ptr<FileSystem> files = nullptr;  ///< Null: the system's.
  };

  static constexpr std::int64_t kKeepAside_s = 30 * 24 * 3600;
  static constexpr std::size_t kMaxAside = 16;  ///< Files; the newest stay.
  static constexpr std::size_t kMaxAside_bytes = 1U << 30;

  /// Makes the folder when there is none. Whatever the folder holds, the state is the newest that can be proven: of the
  /// log, up to where it is damaged, or of the checkpoint's copy; an empty one when nothing can be read. What is given up
  /// for it is kept aside and said in a warning. While the folder cannot be written, nothing in it is changed and
  /// keep() refuses with the reason.
  ///
  /// The state has the epoch that the folder holds if all of the log is there, or all but a torn end: of that no edit
  /// was answered on any disk that keeps what it says it keeps. A disk that does not, like a backup that is put back or
  /// a log that ends between two records, cannot be distinguished here, and need not be: the server lets a client resume
  /// only from a revision that it holds with the same root, and sends all others a snapshot. A new epoch would say to
  /// clients that the fate of their edits under way is not known, though they are applied exactly once.
  /// Otherwise it has `freshEpoch`: edits that were answered may be gone, and other revisions take their numbers.
  /// Refused: a folder that cannot be made, or that another server uses.
  [[nodiscard]] static Result<Opened> open(const std::filesystem::path& folder, std::uint64_t freshEpoch,
                                           Options options);

  [[nodiscard]] Result<void> keep(const SequencerState& before, const Edits& edits, const Assets& assets) override;
  /// AssetFiles::prepare().
  void prepare(const std::shared_ptr<const Asset>& asset) override { assets_.prepare(asset); }
  void resetTo(const SequencerState& state, const Assets& assets) override;
  /// AssetFiles::read().
  [[nodiscard]] Result<std::string> readAsset(const ContentHash& hash) { return assets_.read(hash); }

  /// The asset's file was found damaged: resetTo() writes it again.
  void distrust(const ContentHash& asset) { assets_.distrust(asset); }

 private:
  struct Found;
  struct SetAside {
    std::string name;   // empty: there is none, and only its time is noted
    std::string aside;  // the name that it gets
  };
  std::filesystem::path folder_;
  Options options_;
  FileSystem& files_;
  AssetFiles assets_;
  FileSystem::OpenFile lock_;
  FileSystem::OpenFile log_;  // none: it is not known what is in the file, and only a new one is known
  std::size_t size_ = 0;      // of the log, good records only
  RecordWriter writer_;
  Assets unsavedAssets_;              // of the state, to be stored before the next edit
  std::size_t written_ = 0;           // log and assets, since the last checkpoint
  std::size_t nextCheckpoint_ = 0;    // when written_ has come so far
  std::vector<SetAside> toSetAside_;  // to be left aside by the next checkpoint
  bool failing_ = false;
  bool reserved_ = false;
  bool startsFresh_ = false;  // there is neither log nor checkpoint that can be read

  StateFolder(std::filesystem::path folder, Options options)
      : folder_(std::move(folder)),
        options_(std::move(options)),
        files_(*options_.files),
        assets_(folder_ / "assets", files_) {}

  SequencerState load(std::uint64_t freshEpoch);
  [[nodiscard]] Found look(const std::string& name, const std::vector<FileSystem::Entry>& entries);
  SequencerState startFresh(std::uint64_t freshEpoch, const Found& log, const Found& copy);
  Result<void> continueLog(const SavedState& saved, std::string_view bytes, std::size_t beginning);
  std::string setAside(const std::string& name);
  void warnOf(const LogDamage& damage, bool logIsThere, std::uint64_t revision);
  void note(const Result<void>& kept);
  Result<void> checkpoint(const SequencerState& state);
  Result<void> leaveAside();
  Result<void> tryToKeep(const SequencerState& before, const Edits& edits, const Assets& assets);
  Result<void> storeUnsavedAssets();
  Result<void> append(const std::string& records);
  Result<void> storeAsset(const Asset& asset);
  void planCheckpoint(std::size_t lastSize);
  void reserve();
  bool giveBackReserve();
  [[nodiscard]] std::int64_t collectAside();
};

struct StateFolder::Opened {
  std::unique_ptr<StateFolder> folder;
  SequencerState state;
};

}  // namespace haptics
