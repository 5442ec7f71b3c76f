#include "haptic_server/state/state_folder.h"

#include <algorithm>
#include <exception>

#include "haptic_server/scene/lost_parts.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLogName = "log";
constexpr const char* kCheckpointName = "checkpoint";
constexpr const char* kReserveName = "reserve";
/// A reserve is only taken of a disk that has several times as much.
constexpr std::size_t kReserveOfFree = 4;

AssetFiles::Names assetNames(const SequencerState& state) {
  AssetFiles::Names names;
  const auto add = [&](const ObjectRecord& object) {
    for (const AssetName& asset : object.assets()) names.insert(asset.hash.hex());
  };
  for (const auto& object : state.history->version.objects()) add(*object);
  for (const auto& object : stillLost(state)) add(*object);
  return names;
}

std::uint64_t revisionOf(const SavedState& saved) { return saved.state.history->version.revision(); }

}  // namespace

struct StateFolder::Found {
  bool there = false;
  std::optional<std::string> bytes;
  std::string why;  // there are none
};

Result<StateFolder::Opened> StateFolder::open(const fs::path& folder, std::uint64_t freshEpoch, Options options) {
  const fs::path path = fs::absolute(folder / "").lexically_normal().parent_path();
  if (!options.files) options.files = systemFiles();
  std::unique_ptr<StateFolder> opened(new StateFolder(path, std::move(options)));
  if (auto made = makeFolderDurably(opened->files_, path); !made) return tl::unexpected(std::move(made).error());
  auto lock = opened->files_.lock(path / "lock");
  if (!lock) return tl::unexpected(std::move(lock).error());
  if (!*lock) return refused((path / "lock").string(), "another server uses this folder");
  opened->lock_ = *std::move(lock);
  (void)opened->assets_.makeFolder();  // checkpoint() says why there can be none
  SequencerState state = opened->load(freshEpoch);
  return Opened{std::move(opened), std::move(state)};
}

StateFolder::Found StateFolder::look(const std::string& name, const std::vector<FileSystem::Entry>& entries) {
  if (!std::ranges::count(entries, name, &FileSystem::Entry::name)) return {false, std::nullopt, "is missing"};
  auto bytes = files_.read(folder_ / name);
  if (!bytes) return {true, std::nullopt, bytes.error().reason};
  return {true, *std::move(bytes), ""};
}

SequencerState StateFolder::load(std::uint64_t freshEpoch) {
  const auto entries = files_.list(folder_).value_or(std::vector<FileSystem::Entry>{});
  reserved_ = std::ranges::count(entries, kReserveName, &FileSystem::Entry::name) > 0;
  Found log = look(kLogName, entries), copy = look(kCheckpointName, entries);

  std::optional<SavedState> saved;
  if (log.bytes) {
    if (auto read = readLog(*log.bytes)) {
      saved = *std::move(read);
    } else {
      log.why = read.error().text();
    }
  }
  const bool beginsWell = saved.has_value();
  if ((!saved || saved->damage) && copy.bytes) {
    if (const auto alone = readLog(*copy.bytes); alone && alone->damage) copy.bytes->resize(alone->damage->offset);
    auto behind = log.bytes ? readLogBehind(*copy.bytes, *log.bytes) : readLog(*copy.bytes);
    if (!behind) {
      copy.why = behind.error().text();
    } else if (!saved || revisionOf(*behind) > revisionOf(*saved)) {
      if (!log.bytes) behind->damage = LogDamage{false, 0, 0, log.why};
      if (saved) behind->damage = saved->damage;
      saved = *std::move(behind);
    }
  }
  if (!saved) return startFresh(freshEpoch, log, copy);

  SequencerState& state = saved->state;
  if (saved->damage) {
    warnOf(*saved->damage, log.there, revisionOf(*saved));
    if (!saved->damage->torn) {
      auto history = std::make_shared<SceneHistory>(*state.history);
      history->epoch = freshEpoch;
      state.history = std::move(history);
    }
  } else if (!beginsWell) {
    options_.warning((folder_ / kLogName).string() +
                     ": the beginning was damaged and is restored from its copy; nothing is lost");
  }
  const bool whole = beginsWell && !saved->damage && copy.bytes && log.bytes->starts_with(*copy.bytes);
  size_ = whole ? log.bytes->size() : 0;
  note(whole ? continueLog(*saved, *log.bytes, copy.bytes->size()) : checkpoint(state));
  return std::move(state);
}

/// What was read, and its name, may be in memory alone: where a wait for the disk had failed and the process then ended,
/// the system still shows what will never be on the disk. Nothing is built on it before it is written and waited for again.
Result<void> StateFolder::continueLog(const SavedState& saved, std::string_view bytes, std::size_t beginning) {
  auto log = files_.open(folder_ / kLogName);
  if (!log) return tl::unexpected(std::move(log).error());
  if (auto written = writeDurably(**log, bytes, 0); !written) return written;
  if (auto named = files_.syncFolder(folder_); !named) return named;
  log_ = *std::move(log);
  writer_ = saved.writer;
  const AssetFiles::Bytes assets = assets_.bytes(assetNames(saved.state));
  written_ = size_ - beginning + assets.others;
  planCheckpoint(beginning + assets.named);
  reserve();
  return {};
}

/// Nothing of a log can be read.
SequencerState StateFolder::startFresh(std::uint64_t freshEpoch, const Found& log, const Found& copy) {
  const auto assets = files_.list(assets_.folder());
  std::string found;
  if (log.there) found += std::string(kLogName) + " " + log.why + " (kept as " + setAside(kLogName) + "); ";
  if (copy.there)
    found += std::string(kCheckpointName) + " " + copy.why + " (kept as " + setAside(kCheckpointName) + "); ";
  if (found.empty() && assets && !assets->empty()) {
    found = "there are assets but neither log nor checkpoint; ";
    setAside("");
  }
  if (!found.empty()) {
    options_.warning(folder_.string() + ": NOTHING OF THE KEPT SCENE CAN BE READ, AND A NEW ONE IS BEGUN: " + found +
                     "what was found stays there, with its assets, for " + std::to_string(kKeepAside_s / 86'400) +
                     " days");
  }
  startsFresh_ = true;
  SequencerState state;
  state.history = std::make_shared<const SceneHistory>(SceneHistory{freshEpoch, {}, {}});
  note(checkpoint(state));
  return state;
}

/// @return The name that it gets.
std::string StateFolder::setAside(const std::string& name) {
  const auto entries = files_.list(folder_).value_or(std::vector<FileSystem::Entry>{});
  std::string aside;
  std::int64_t time_s = files_.now_s();
  do {
    aside = (name.empty() ? kLogName : name) + std::string(kAsideMark) + std::to_string(time_s++);
  } while (std::ranges::count(entries, aside, &FileSystem::Entry::name) > 0);
  toSetAside_.push_back({name, aside});
  return aside;
}

void StateFolder::warnOf(const LogDamage& damage, bool logIsThere, std::uint64_t revision) {
  const std::string where = (folder_ / kLogName).string() + ": ";
  const std::string scene = "the scene is that of revision " + std::to_string(revision);
  if (damage.torn) {
    options_.warning(
        where + damage.reason + " at byte " + std::to_string(damage.offset) + ": " + std::to_string(damage.dropped) +
        " bytes are dropped; " + scene +
        ". They were being written when the server or the power went: no edit in them was answered, unless "
        "the disk had said that it held what it did not");
    return;
  }
  std::string text = where + damage.reason;
  if (damage.dropped > 0) {
    text += " at byte " + std::to_string(damage.offset) + ": " + std::to_string(damage.dropped) + " bytes are dropped";
  }
  text += "; " + scene + ". Edits after it are lost, if there were any: they may have been answered";
  if (logIsThere) text += ". The log as it was found is kept as " + setAside(kLogName);
  options_.warning(text);
}

Result<void> StateFolder::keep(const SequencerState& before, const Edits& edits, const Assets& assets) {
  Result<void> kept;
  try {
    kept = tryToKeep(before, edits, assets);
    if (!kept && giveBackReserve()) kept = tryToKeep(before, edits, assets);
  } catch (const std::exception& failure) {
    log_.reset();
    kept = refused("", failure.what());
  }
  note(kept);
  if (kept) return {};
  return refused("state", "the server cannot keep edits now (" + kept.error().reason + "); send it again later");
}

void StateFolder::resetTo(const SequencerState& state, const Assets& assets) {
  log_.reset();  // what it holds leads elsewhere
  Result<void> kept;
  try {
    unsavedAssets_ = assets;
    kept = storeUnsavedAssets();
    if (kept) kept = checkpoint(state);
  } catch (const std::exception& failure) {
    kept = refused("", failure.what());
  }
  note(kept);
}

void StateFolder::note(const Result<void>& kept) {
  if (!kept && !failing_) {
    options_.warning(folder_.string() + ": edits are rejected until they can be kept: " + kept.error().text());
  }
  if (kept && failing_) options_.info("edits are kept again");
  failing_ = !kept;
}

Result<void> StateFolder::tryToKeep(const SequencerState& before, const Edits& edits, const Assets& assets) {
  if (auto stored = storeUnsavedAssets(); !stored) return stored;
  written_ += assets_.takePrepared_bytes();
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
  if (auto appended = append(records); !appended) return appended;
  writer_ = writer;
  size_ += records.size();
  written_ += records.size();
  return {};
}

/// On an error the records do not count: they are taken out again.
Result<void> StateFolder::append(const std::string& records) {
  auto done = log_->write(records, size_);
  const bool waited = done.has_value();
  if (waited) done = log_->sync();
  if (done) return {};
  const bool takenOut = log_->truncate(size_) && log_->sync();
  // After a failed wait for the disk nobody knows what is on it, nor will a second wait tell: on with another file. If
  // the records could not be taken out either, a crash before that file is there brings them back.
  if (waited || !takenOut) log_.reset();
  return done;
}

Result<void> StateFolder::storeUnsavedAssets() {
  for (; !unsavedAssets_.empty(); unsavedAssets_.pop_back()) {
    if (auto stored = storeAsset(*unsavedAssets_.back()); !stored) return stored;
  }
  return {};
}

Result<void> StateFolder::checkpoint(const SequencerState& state) {
  std::string bytes(kLogHead);
  RecordWriter writer;
  writer.append(bytes, checkpointRecord(state));
  if (auto made = assets_.makeFolder(); !made) return made;
  const auto placeCopy = [&]() -> Result<void> {
    const fs::path name = folder_ / "checkpoint.new";
    if (const auto copy = createDurably(files_, name, bytes); !copy) return tl::unexpected(copy.error());
    return renameDurably(files_, name, folder_ / kCheckpointName);
  };
  const auto placeLog = [&]() -> Result<void> {
    const fs::path name = folder_ / "log.new";
    auto log = createDurably(files_, name, bytes);
    if (!log) return tl::unexpected(std::move(log).error());
    if (auto aside = leaveAside(); !aside) return aside;
    log_.reset();  // which of the two a crash would leave is not known until the rename is durable
    if (auto named = renameDurably(files_, name, folder_ / kLogName); !named) return named;
    log_ = *std::move(log);
    return {};
  };
  // The copy first: whatever becomes of the log then, the state is there. Of a folder without any it is the log:
  // without one, a copy means that a log is gone.
  if (!startsFresh_) {
    if (auto placed = placeCopy(); !placed) return placed;
  }
  if (auto placed = placeLog(); !placed) return placed;
  if (startsFresh_) {
    if (auto placed = placeCopy(); !placed)
      options_.warning("there is no copy of the checkpoint: " + placed.error().text());
  }
  startsFresh_ = false;
  writer_ = writer;
  size_ = bytes.size();
  const auto named = assetNames(state);
  assets_.collect(named, collectAside());
  written_ = 0;
  planCheckpoint(size_ + assets_.bytes(named).named);
  reserve();
  return {};
}

/// From now on a crash finds no log, until the next rename; the checkpoint's copy holds what there is.
Result<void> StateFolder::leaveAside() {
  for (; !toSetAside_.empty(); toSetAside_.pop_back()) {
    const auto& [name, aside] = toSetAside_.back();
    if (name.empty()) {
      if (auto noted = createDurably(files_, folder_ / aside, ""); !noted) return tl::unexpected(noted.error());
    } else if (auto renamed = renameDurably(files_, folder_ / name, folder_ / aside); !renamed) {
      return renamed;
    }
  }
  return {};
}

void StateFolder::planCheckpoint(std::size_t lastSize) {
  nextCheckpoint_ = std::max(options_.checkpointAfter_bytes, Options::kCheckpointAfterSizes * lastSize);
}

Result<void> StateFolder::storeAsset(const Asset& asset) {
  const auto written_bytes = assets_.store(asset);
  if (!written_bytes) return tl::unexpected(written_bytes.error());
  written_ += *written_bytes;
  return {};
}

void StateFolder::reserve() {
  if (reserved_ || options_.reserve_bytes == 0) return;
  if (files_.free_bytes(folder_) < kReserveOfFree * options_.reserve_bytes) return;
  reserved_ = files_.allocate(folder_ / kReserveName, options_.reserve_bytes).has_value();
}

/// False: there is none, or it is not space that is missing.
bool StateFolder::giveBackReserve() {
  if (!reserved_ || files_.free_bytes(folder_) >= options_.reserve_bytes) return false;
  reserved_ = false;
  if (!files_.remove(folder_ / kReserveName)) return false;
  options_.warning(folder_.string() + ": the disk is full; edits are kept in the last " +
                   std::to_string(options_.reserve_bytes >> 20) + " MiB, which were held in reserve");
  return true;
}

/// @return Since when the newest log is aside; 0: there is none.
std::int64_t StateFolder::collectAside() {
  struct Aside {
    fs::path path;
    std::int64_t since_s;
    std::size_t size;
    bool isAsset;
  };
  std::vector<Aside> aside;
  for (const bool isAsset : {false, true}) {
    const fs::path folder = isAsset ? assets_.folder() : folder_;
    for (const auto& entry : files_.list(folder).value_or(std::vector<FileSystem::Entry>{})) {
      if (const auto since_s = asideSince(entry.name))
        aside.push_back({folder / entry.name, *since_s, entry.size, isAsset});
    }
  }
  std::ranges::sort(aside, std::ranges::greater(), &Aside::since_s);
  std::size_t files = 0, bytes = 0;
  std::int64_t newest_s = 0;
  for (const auto& [path, since_s, size, isAsset] : aside) {
    const bool stays = files < kMaxAside && (files == 0 || bytes + size <= kMaxAside_bytes);
    if (!stays || files_.now_s() - since_s > kKeepAside_s) {
      files_.remove(path);
      continue;
    }
    ++files;
    bytes += size;
    if (!isAsset) newest_s = std::max(newest_s, since_s);
  }
  return newest_s;
}

}  // namespace haptics
