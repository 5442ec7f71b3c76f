#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "haptic_server/scene/asset_store.h"
#include "haptic_server/state/durable_file.h"

namespace haptics {

/// In the name of a file that was given up, before the time at which it was.
inline constexpr std::string_view kAsideMark = ".damaged-";
/// That time (Unix, seconds); nothing for the name of another file.
[[nodiscard]] std::optional<std::int64_t> asideSince(std::string_view name);

/// The folder of a state's assets: a file each, named by its hash, durable before an edit that names it is. Any thread.
class AssetFiles {
 public:
  using Names = std::unordered_set<std::string>;  ///< Hashes, in hex.
  struct Bytes {
    std::size_t named = 0;
    std::size_t others = 0;
  };

  /// Limit for assets that no state names; a state that was given up may.
  static constexpr std::size_t kMaxUnnamed_bytes = 1U << 30;

  /// `files` outlives this.
  AssetFiles(std::filesystem::path folder, FileSystem& files) : folder_(std::move(folder)), files_(files) {}

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
  [[nodiscard]] Result<void> makeFolder() { return makeFolderDurably(files_, folder_); }
  /// With this hash. Refused: missing, unreadable, or damaged, in which case the file is kept aside.
  [[nodiscard]] Result<std::string> read(const ContentHash& hash);
  /// Writes its file unless it is there. @return Bytes written.
  [[nodiscard]] Result<std::size_t> store(const Asset& asset);
  /// Writes the file of an asset that no state names yet; it stays as long as the asset is held. One that cannot be
  /// written now is tried again, and that is said, by store().
  void prepare(const std::shared_ptr<const Asset>& asset);
  [[nodiscard]] std::size_t takePrepared_bytes();  ///< Bytes that prepare() has written since the last call.
  void distrust(const ContentHash& asset);         ///< The file was found damaged: store() writes it again.

  /// Removes the files that neither the state names nor prepare() wrote, unless something that was given up up to this
  /// time (Unix, seconds) may name them.
  void collect(Names named, std::int64_t keepUpTo_s);
  [[nodiscard]] Bytes bytes(const Names& named) const;  ///< Of the files that the state names, and of the others.

 private:
  [[nodiscard]] Result<void> write(const Asset& asset, const char* unfinishedMark);
  [[nodiscard]] Names preparedNames();

  const std::filesystem::path folder_;
  FileSystem& files_;
  std::mutex mutex_;                                                      // guards what follows
  std::unordered_set<ContentHash> stored_;                                // durable, as this process knows
  std::unordered_map<ContentHash, std::weak_ptr<const Asset>> prepared_;  // perhaps being written
  std::size_t prepared_bytes_ = 0;
};

}  // namespace haptics
