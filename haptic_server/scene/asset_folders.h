#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// The folders below which scenes and clients may name files.
class AssetFolders {
 public:
  /// Files are looked for in the folders in this order.
  explicit AssetFolders(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  /// Canonical. Refused, naming `field`: a file that is not below a folder once `..` and symbolic links are followed, or
  /// is none; errors never say where the folders lie.
  [[nodiscard]] Result<std::filesystem::path> locate(const std::string& path, const std::string& field) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

/// Where a file lies is the server's affair: its path as clients know it instead.
[[nodiscard]] std::string seenFromOutside(std::string text, const std::filesystem::path& file,
                                          const std::string& nameForClients);

}  // namespace haptics
