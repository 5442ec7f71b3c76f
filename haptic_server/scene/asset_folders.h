#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// A file below one of the folders; both canonical.
struct LocatedFile {
  std::filesystem::path file;
  std::filesystem::path folder;
};

/// The folders below which scenes and clients may name files.
class AssetFolders {
 public:
  /// Files are looked for in the folders in this order.
  explicit AssetFolders(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  /// Refused, naming `field`: a file that is not below a folder once `..` and symbolic links are followed, or
  /// is none; errors never say where the folders lie.
  [[nodiscard]] Result<LocatedFile> locate(const std::string& path, const std::string& field) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

/// Where a file lies is the server's affair: its path as clients know it instead.
[[nodiscard]] std::string seenFromOutside(std::string text, const std::filesystem::path& file,
                                          const std::string& nameForClients);

}  // namespace haptics
