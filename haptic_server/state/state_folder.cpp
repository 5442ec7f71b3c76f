#include "haptic_server/state/state_folder.h"

#include <fcntl.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <system_error>
#include <utility>

#include "common/mesh/file_bytes.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLogName = "log";
constexpr const char* kCheckpointName = "checkpoint";
constexpr const char* kAssetFolder = "assets";
constexpr const char* kDamagedPrefix = "log.damaged-";

bool holdsDamagedLog(const fs::path& folder) {
  return std::ranges::any_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    return entry.path().filename().string().starts_with(kDamagedPrefix);
  });
}

std::unordered_set<std::string> assetNames(const SceneVersion& version) {
  std::unordered_set<std::string> names;
  for (const auto& object : version.objects()) {
    for (const AssetName& asset : object->assets()) names.insert(asset.hash.hex());
  }
  return names;
}

}  // namespace

Result<StateFolder::Opened> StateFolder::open(const fs::path& folder, std::uint64_t freshEpoch, Options options) {
  const fs::path path = fs::absolute(folder / "").lexically_normal().parent_path();
  if (auto made = makeFolderDurably(path / kAssetFolder); !made) return tl::unexpected(std::move(made).error());

  std::unique_ptr<StateFolder> opened(new StateFolder(path, std::move(options)));
  auto lock = lockFile(path / "lock");
  if (!lock) return tl::unexpected(std::move(lock).error());
  opened->lock_ = *std::move(lock);
  auto state = opened->load(freshEpoch);
  if (!state) return tl::unexpected(std::move(state).error());
  return Opened{std::move(opened), *std::move(state)};
}

Result<SequencerState> StateFolder::load(std::uint64_t freshEpoch) {
  const fs::path path = folder_ / kLogName;
  if (!fs::exists(path)) {
    SequencerState state;
    state.history = std::make_shared<const SceneHistory>(SceneHistory{freshEpoch, {}, {}});
    if (auto made = checkpoint(state); !made) return tl::unexpected(std::move(made).error());
    return state;
  }
  const auto bytes = readFile(path);
  if (!bytes) return refused(path.string(), bytes.error().text());
  const auto beginning = readFile(folder_ / kCheckpointName);
  auto saved = readLog(*bytes);
  const bool beginsWell = saved.has_value();
  if (!beginsWell && beginning) {
    if (auto repaired = readLogBehind(*beginning, *bytes)) saved = std::move(repaired);
  }
  if (!saved) return refused(path.string(), saved.error().text() + ". Move it away to start without it");
  if (saved->damage) {
    if (auto handled = giveUpDamaged(*bytes, *saved->damage); !handled) return tl::unexpected(handled.error());
    auto history = std::make_shared<SceneHistory>(*saved->state.history);
    history->epoch = freshEpoch;
    saved->state.history = std::move(history);
  } else if (!beginsWell) {
    options_.warning(path.string() + ": the beginning was damaged and is restored from its copy; nothing is lost");
  }
  if (saved->damage || !beginsWell || !beginning || !bytes->starts_with(*beginning)) {
    if (auto made = checkpoint(saved->state); !made) return tl::unexpected(std::move(made).error());
    return std::move(saved->state);
  }
  auto log = openForWriting(path);
  if (!log) return tl::unexpected(std::move(log).error());
  log_ = *std::move(log);
  writer_ = saved->writer;
  size_ = bytes->size();
  const AssetBytes assets = assetBytes(saved->state.history->version);
  written_ = size_ - beginning->size() + assets.others;
  planCheckpoint(beginning->size() + assets.named);
  return std::move(saved->state);
}

Result<void> StateFolder::giveUpDamaged(std::string_view log, const LogDamage& damage) {
  const std::string where = (folder_ / kLogName).string() + ": " + damage.reason + " at byte " +
                            std::to_string(damage.offset) + ": " + std::to_string(damage.dropped) +
                            " bytes are dropped";
  if (damage.cutOff) {
    options_.warning(where + ". It was being written when the server ended, and no edit in it had been accepted");
    return {};
  }
  const fs::path aside = folder_ / (kDamagedPrefix + std::to_string(std::time(nullptr)));
  if (auto kept = createDurably(aside, log); !kept) return tl::unexpected(std::move(kept).error());
  options_.warning(where +
                   ", ACCEPTED EDITS AMONG THEM. The scene is that before the damage; the damaged log is kept as " +
                   aside.filename().string());
  return {};
}

Result<std::string> StateFolder::readAsset(const ContentHash& hash) const {
  const fs::path path = folder_ / kAssetFolder / hash.hex();
  auto bytes = readFile(path);
  if (!bytes) return refused(path.string(), bytes.error().text());
  return bytes;
}

Result<void> StateFolder::keep(const SequencerState& before, const Edits& edits, const Assets& assets) {
  Result<void> kept;
  try {
    kept = tryToKeep(before, edits, assets);
  } catch (const std::exception& failure) {
    log_ = {};
    kept = refused("", failure.what());
  }
  if (!kept && !failing_) options_.warning("edits are rejected until they can be kept: " + kept.error().text());
  if (kept && failing_) options_.info("edits are kept again");
  failing_ = !kept;
  if (kept) return {};
  return refused("state", "the server cannot keep edits now (" + kept.error().reason + "); send it again later");
}

Result<void> StateFolder::tryToKeep(const SequencerState& before, const Edits& edits, const Assets& assets) {
  if (!log_ || written_ >= nextCheckpoint_) {
    auto made = checkpoint(before);
    if (!made && !log_) return made;
    if (!made) nextCheckpoint_ = written_ + options_.checkpointAfter_bytes;  // the log can wait
  }
  for (const auto& asset : assets) {
    if (auto stored = storeAsset(*asset); !stored) return stored;
  }
  RecordWriter writer = writer_;
  std::string records;
  for (const auto& edit : edits) writer.append(records, editRecord(*edit));
  if (auto written = writeDurably(log_, records, size_); !written) {
    // After a failed wait for the disk nobody knows what is on it, nor will a second wait tell: on with another file.
    // These edits are rejected; if they cannot be taken out either, a crash before that file is there brings them back.
    (void)truncateDurably(log_, size_);
    log_ = {};
    return written;
  }
  writer_ = writer;
  size_ += records.size();
  written_ += records.size();
  return {};
}

Result<void> StateFolder::checkpoint(const SequencerState& state) {
  std::string bytes(kLogHead);
  RecordWriter writer;
  writer.append(bytes, checkpointRecord(state));
  if (const auto copy = createDurably(folder_ / "checkpoint.new", bytes); !copy) return tl::unexpected(copy.error());
  if (auto named = renameDurably(folder_ / "checkpoint.new", folder_ / kCheckpointName); !named) return named;
  auto log = createDurably(folder_ / "log.new", bytes);
  if (!log) return tl::unexpected(std::move(log).error());
  if (auto named = renameDurably(folder_ / "log.new", folder_ / kLogName); !named) {
    log_ = {};  // which of the two a crash would leave is not known
    return named;
  }
  log_ = *std::move(log);
  writer_ = writer;
  size_ = bytes.size();
  collectAssets(state.history->version);
  written_ = 0;
  planCheckpoint(size_ + assetBytes(state.history->version).named);
  return {};
}

void StateFolder::planCheckpoint(std::size_t lastSize) {
  nextCheckpoint_ = std::max(options_.checkpointAfter_bytes, Options::kCheckpointAfterSizes * lastSize);
}

Result<void> StateFolder::storeAsset(const Asset& asset) {
  if (stored_.contains(asset.name.hash)) return {};
  const fs::path path = folder_ / kAssetFolder / asset.name.hash.hex();
  const fs::path unfinished = path.string() + ".new";
  if (auto made = createDurably(unfinished, *asset.encoded); !made) return tl::unexpected(std::move(made).error());
  if (auto renamed = renameDurably(unfinished, path); !renamed) return renamed;
  stored_.insert(asset.name.hash);
  written_ += asset.encoded->size();
  return {};
}

/// Removes the assets that the version does not name, unless a damaged log may name them.
void StateFolder::collectAssets(const SceneVersion& version) {
  const auto named = assetNames(version);
  std::erase_if(stored_, [&](const ContentHash& hash) { return !named.contains(hash.hex()); });
  if (holdsDamagedLog(folder_)) return;
  for (const auto& entry : fs::directory_iterator(folder_ / kAssetFolder)) {
    std::error_code ignored;  // a file that cannot be removed costs its space
    if (!named.contains(entry.path().filename().string())) fs::remove(entry.path(), ignored);
  }
}

StateFolder::AssetBytes StateFolder::assetBytes(const SceneVersion& version) const {
  const auto named = assetNames(version);
  AssetBytes bytes;
  for (const auto& entry : fs::directory_iterator(folder_ / kAssetFolder)) {
    (named.contains(entry.path().filename().string()) ? bytes.named : bytes.others) += entry.file_size();
  }
  return bytes;
}

}  // namespace haptics
