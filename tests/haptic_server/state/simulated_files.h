#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "haptic_server/state/durable_file.h"

namespace haptics::test {

/// The power is gone in the middle of a call. No std::exception: nothing on the way handles it.
struct PowerFailure {};

/// Ways in which the state folder could use its files wrongly, to test the test: each does to the disk what the broken
/// code would.
enum class FileMutant {
  kNone,
  kLogNotSynced,            ///< An edit is answered when it is written, not when it is durable.
  kNewFilesNotSynced,       ///< A file is renamed before its bytes are durable.
  kFolderNotSynced,         ///< The new log's name is not waited for.
  kAssetFolderNotSynced,    ///< An asset's name is not waited for.
  kAssetAfterLog,           ///< An asset is durable only after the log that names it.
  kFailedWaitTakenForDone,  ///< An error of waiting for the disk is not looked at.
};

/// A disk and its file system in memory. What was not waited for may be lost when the power fails: sectors of a file's
/// bytes and names in a folder, each alone and in any order. Any call may fail.
class SimulatedFiles final : public FileSystem {
 public:
  explicit SimulatedFiles(std::uint64_t seed, FileMutant mutant = FileMutant::kNone);
  ~SimulatedFiles() override;

  // ---- What goes wrong ----
  double failing = 0;  ///< Chance of each call to be refused: no space, no descriptor, an error of the disk.
  bool readOnly = false;
  std::size_t capacity_bytes = std::size_t(1) << 40;
  /// In the call after so many that change something; < 0: never.
  void powerFailsAfter(std::int64_t calls) { callsLeft_ = calls; }
  /// The computer starts again with what the disk holds.
  void loseWhatWasNotWaitedFor();

  // ---- To look and to damage ----
  [[nodiscard]] std::size_t used_bytes() const;
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  [[nodiscard]] std::string bytes(const std::filesystem::path& path) const;
  void put(const std::filesystem::path& path, const std::string& bytes);
  void take(const std::filesystem::path& path);

  // ---- FileSystem ----
  Result<std::string> read(const std::filesystem::path& path) override;
  Result<OpenFile> open(const std::filesystem::path& path) override;
  Result<OpenFile> create(const std::filesystem::path& path) override;
  Result<void> rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
  Result<void> remove(const std::filesystem::path& path) override;
  Result<void> allocate(const std::filesystem::path& path, std::size_t bytes) override;
  Result<std::vector<Entry>> list(const std::filesystem::path& folder) override;
  bool isFolder(const std::filesystem::path& path) override;
  Result<void> makeFolder(const std::filesystem::path& path) override;
  Result<void> syncFolder(const std::filesystem::path& folder) override;
  Result<OpenFile> lock(const std::filesystem::path& path) override;
  std::size_t free_bytes(const std::filesystem::path& folder) override;
  std::int64_t now_s() override { return ++clock_s_; }

 private:
  class Open;
  struct Write {
    std::size_t offset = 0;
    std::string bytes;
    bool truncates = false;  // to the offset
  };
  struct Inode {
    std::string now, durable;
    std::vector<Write> pending;
    std::int64_t changed_s = 0;
    std::size_t allocated = 0;
  };
  using Names = std::map<std::filesystem::path, std::shared_ptr<Inode>>;
  /// `to` becomes the inode, or is gone; `from` is gone.
  struct Naming {
    std::filesystem::path from, to;
    std::shared_ptr<Inode> inode;
  };

  std::mt19937_64 random_;
  const FileMutant mutant_;
  Names now_, durable_;
  std::set<std::filesystem::path> folders_, durableFolders_;
  std::vector<Naming> namings_;
  std::vector<std::shared_ptr<Inode>> lateAssets_;  // kAssetAfterLog
  std::int64_t callsLeft_ = -1;
  std::int64_t clock_s_ = 1'000'000;
  bool locked_ = false;

  [[nodiscard]] bool chance(double p) { return std::uniform_real_distribution<>(0, 1)(random_) < p; }
  [[nodiscard]] Result<void> mayChange(const std::filesystem::path& path);
  [[nodiscard]] Result<void> mayFail(const std::filesystem::path& path);
  static void apply(Names& names, const Naming& naming);
  static void apply(std::string& bytes, const Write& write);
  void name(Naming naming);
  void settle(Inode& inode, double share);
  void sync(Inode& inode);
};

}  // namespace haptics::test
