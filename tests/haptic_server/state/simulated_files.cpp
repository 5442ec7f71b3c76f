#include "tests/haptic_server/state/simulated_files.h"

#include <algorithm>
#include <utility>

namespace haptics::test {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kSector_bytes = 512;

bool isLog(const fs::path& path) { return path.filename() == "log" || path.filename() == "log.new"; }
bool isAsset(const fs::path& path) { return path.parent_path().filename() == "assets"; }

}  // namespace

class SimulatedFiles::Open final : public FileSystem::File {
 public:
  Open(SimulatedFiles& disk, fs::path path, std::shared_ptr<Inode> inode, bool isNew)
      : disk_(disk), path_(std::move(path)), inode_(std::move(inode)), isNew_(isNew) {}

  Result<void> write(std::string_view bytes, std::size_t offset) override {
    const std::size_t used = disk_.used_bytes();
    const std::size_t grown = std::max(inode_->now.size(), offset + bytes.size()) - inode_->now.size();
    const bool full = used + grown > disk_.capacity_bytes;
    if (full) bytes.remove_suffix(std::min(bytes.size(), used + grown - disk_.capacity_bytes));
    const auto failed = disk_.mayFail(path_);
    if (!failed) bytes = bytes.substr(0, disk_.random_() % (bytes.size() + 1));
    const Write write{offset, std::string(bytes)};
    apply(inode_->now, write);
    inode_->pending.push_back(write);
    inode_->changed_s = disk_.now_s();
    if (auto may = disk_.mayChange(path_); !may) return may;
    if (full) return refused(path_.string(), "No space left on device");
    return failed;
  }
  Result<void> truncate(std::size_t size) override {
    if (auto may = disk_.mayChange(path_); !may) return may;
    if (auto may = disk_.mayFail(path_); !may) return may;
    const Write write{size, "", true};
    apply(inode_->now, write);
    inode_->pending.push_back(write);
    return {};
  }
  Result<void> sync() override {
    if (auto may = disk_.mayChange(path_); !may) return may;
    if (auto may = disk_.mayFail(path_); !may) {
      disk_.settle(*inode_, 0.5);  // what is not there by now will never be
      if (disk_.mutant_ == FileMutant::kFailedWaitTakenForDone) return {};
      return may;
    }
    const bool first = std::exchange(isNew_, false);
    if (disk_.mutant_ == FileMutant::kLogNotSynced && isLog(path_) && !first) return {};
    if (disk_.mutant_ == FileMutant::kNewFilesNotSynced && first) return {};
    if (disk_.mutant_ == FileMutant::kAssetAfterLog && isAsset(path_)) {
      disk_.lateAssets_.push_back(inode_);
      return {};
    }
    disk_.sync(*inode_);
    if (isLog(path_)) {
      for (const auto& asset : std::exchange(disk_.lateAssets_, {})) {
        if (auto may = disk_.mayChange(path_); !may) return may;
        disk_.sync(*asset);
      }
    }
    return {};
  }

 private:
  SimulatedFiles& disk_;
  fs::path path_;
  std::shared_ptr<Inode> inode_;
  bool isNew_;  // and was not synced yet
};

SimulatedFiles::SimulatedFiles(std::uint64_t seed, FileMutant mutant) : random_(seed), mutant_(mutant) {}
SimulatedFiles::~SimulatedFiles() = default;

void SimulatedFiles::apply(std::string& bytes, const Write& write) {
  if (write.truncates) {
    bytes.resize(std::min(bytes.size(), write.offset));
    return;
  }
  if (write.bytes.empty()) return;
  if (bytes.size() < write.offset + write.bytes.size()) bytes.resize(write.offset + write.bytes.size(), '\0');
  bytes.replace(write.offset, write.bytes.size(), write.bytes);
}

void SimulatedFiles::apply(Names& names, const Naming& naming) {
  if (!naming.from.empty()) names.erase(naming.from);
  if (!naming.to.empty()) names[naming.to] = naming.inode;
}

void SimulatedFiles::name(Naming naming) {
  apply(now_, naming);
  namings_.push_back(std::move(naming));
}

/// Of what is pending, sector by sector, so much reaches the disk, and no more ever will.
void SimulatedFiles::settle(Inode& inode, double share) {
  for (const Write& write : std::exchange(inode.pending, {})) {
    if (write.truncates) {
      if (chance(share)) apply(inode.durable, write);
      continue;
    }
    for (std::size_t at = 0; at < write.bytes.size();) {
      const std::size_t piece = std::min(write.bytes.size() - at, kSector_bytes - (write.offset + at) % kSector_bytes);
      if (chance(share)) apply(inode.durable, {write.offset + at, write.bytes.substr(at, piece)});
      at += piece;
    }
  }
}

void SimulatedFiles::sync(Inode& inode) {
  for (const Write& write : std::exchange(inode.pending, {})) apply(inode.durable, write);
}

void SimulatedFiles::loseWhatWasNotWaitedFor() {
  constexpr double kShares[] = {0, 0.5, 0.9, 1};
  const double share = kShares[random_() % 4];
  for (const Naming& naming : std::exchange(namings_, {})) {
    if (chance(share)) apply(durable_, naming);
  }
  for (auto& [path, inode] : durable_) {
    settle(*inode, share);
    inode->now = inode->durable;
  }
  now_ = durable_;
  folders_ = durableFolders_;
  lateAssets_.clear();
  locked_ = false;
  callsLeft_ = -1;
}

std::vector<fs::path> SimulatedFiles::files() const {
  std::vector<fs::path> paths;
  for (const auto& [path, inode] : now_) paths.push_back(path);
  return paths;
}

std::string SimulatedFiles::bytes(const fs::path& path) const {
  const auto at = now_.find(path);
  return at == now_.end() ? std::string() : at->second->now;
}

void SimulatedFiles::put(const fs::path& path, const std::string& bytes) {
  auto& inode = now_[path];
  if (!inode) durable_[path] = inode = std::make_shared<Inode>();
  inode->now = inode->durable = bytes;
}

void SimulatedFiles::take(const fs::path& path) {
  now_.erase(path);
  durable_.erase(path);
}

Result<void> SimulatedFiles::mayChange(const fs::path& path) {
  if (callsLeft_ >= 0 && callsLeft_-- == 0) throw PowerFailure();
  if (readOnly) return refused(path.string(), "Read-only file system");
  return {};
}

Result<void> SimulatedFiles::mayFail(const fs::path& path) {
  constexpr const char* kWhy[] = {"No space left on device", "Too many open files", "Input/output error"};
  if (!chance(failing)) return {};
  return refused(path.string(), kWhy[random_() % 3]);
}

std::size_t SimulatedFiles::used_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [path, inode] : now_) bytes += std::max(inode->now.size(), inode->allocated);
  return bytes;
}

Result<std::string> SimulatedFiles::read(const fs::path& path) {
  const auto at = now_.find(path);
  if (at == now_.end()) return refused(path.string(), "No such file or directory");
  return at->second->now;
}

Result<FileSystem::OpenFile> SimulatedFiles::open(const fs::path& path) {
  if (auto may = mayFail(path); !may) return tl::unexpected(may.error());
  if (readOnly) return refused(path.string(), "Read-only file system");
  const auto at = now_.find(path);
  if (at == now_.end()) return refused(path.string(), "No such file or directory");
  return std::make_unique<Open>(*this, path, at->second, false);
}

Result<FileSystem::OpenFile> SimulatedFiles::create(const fs::path& path) {
  if (auto may = mayChange(path); !may) return tl::unexpected(may.error());
  if (auto may = mayFail(path); !may) return tl::unexpected(may.error());
  if (!folders_.contains(path.parent_path())) return refused(path.string(), "No such file or directory");
  auto inode = now_.contains(path) ? now_[path] : std::make_shared<Inode>();
  if (now_.contains(path)) {
    const Write write{0, "", true};
    apply(inode->now, write);
    inode->pending.push_back(write);
  } else {
    name({{}, path, inode});
  }
  inode->changed_s = now_s();
  return std::make_unique<Open>(*this, path, inode, true);
}

Result<void> SimulatedFiles::rename(const fs::path& from, const fs::path& to) {
  if (auto may = mayChange(from); !may) return may;
  if (auto may = mayFail(from); !may) return may;
  const auto at = now_.find(from);
  if (at == now_.end()) return refused(from.string(), "No such file or directory");
  name({from, to, at->second});
  return {};
}

Result<void> SimulatedFiles::remove(const fs::path& path) {
  if (auto may = mayChange(path); !may) return may;
  if (!now_.contains(path)) return refused(path.string(), "No such file or directory");
  name({path, {}, nullptr});
  return {};
}

Result<void> SimulatedFiles::allocate(const fs::path& path, std::size_t bytes) {
  if (used_bytes() + bytes > capacity_bytes) return refused(path.string(), "No space left on device");
  auto file = create(path);
  if (!file) return tl::unexpected(file.error());
  now_[path]->allocated = bytes;
  return {};
}

Result<std::vector<FileSystem::Entry>> SimulatedFiles::list(const fs::path& folder) {
  if (!folders_.contains(folder)) return refused(folder.string(), "No such file or directory");
  std::vector<Entry> entries;
  for (const auto& [path, inode] : now_) {
    if (path.parent_path() == folder) entries.push_back({path.filename(), inode->now.size(), inode->changed_s});
  }
  return entries;
}

bool SimulatedFiles::isFolder(const fs::path& path) { return path == path.root_path() || folders_.contains(path); }

Result<void> SimulatedFiles::makeFolder(const fs::path& path) {
  if (auto may = mayChange(path); !may) return may;
  folders_.insert(path);
  return {};
}

Result<void> SimulatedFiles::syncFolder(const fs::path& folder) {
  if (auto may = mayChange(folder); !may) return may;
  if (auto may = mayFail(folder); !may) return may;
  if (mutant_ == FileMutant::kFolderNotSynced && folder.filename() != "assets") return {};
  if (mutant_ == FileMutant::kAssetFolderNotSynced && folder.filename() == "assets") return {};
  for (const fs::path& path : folders_) {
    if (path.parent_path() == folder) durableFolders_.insert(path);
  }
  std::erase_if(namings_, [&](const Naming& naming) {
    const fs::path& named = naming.to.empty() ? naming.from : naming.to;
    if (named.parent_path() != folder) return false;
    apply(durable_, naming);
    return true;
  });
  return {};
}

Result<FileSystem::OpenFile> SimulatedFiles::lock(const fs::path& path) {
  return std::make_unique<Open>(*this, path, std::make_shared<Inode>(), false);
}

std::size_t SimulatedFiles::free_bytes(const fs::path&) {
  const std::size_t used = used_bytes();
  return used > capacity_bytes ? 0 : capacity_bytes - used;
}

}  // namespace haptics::test
