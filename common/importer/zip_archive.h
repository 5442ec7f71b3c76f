#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// The files in a ZIP archive that is in memory, by its own list of them: how large each is, is known before it is unpacked.
class ZipArchive {
 public:
  struct Entry {
    std::string name;
    std::uint64_t packed_bytes = 0, size_bytes = 0;
    std::uint64_t at = 0;  ///< Of its head in the archive.
    bool isDeflated = false;
  };

  [[nodiscard]] static bool isOne(std::string_view file) { return file.starts_with("PK\x03\x04"); }
  /// Refused: damaged, of several parts, encrypted, packed otherwise than by deflate, claiming more than its bytes can stand
  /// for.
  /// @param file  Outlives this.
  [[nodiscard]] static Result<ZipArchive> open(std::string_view file);

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] std::uint64_t size_bytes() const;  ///< All of them unpacked.
  /// Refused: damaged, or not as large as the archive says.
  [[nodiscard]] Result<std::string> unpacked(const Entry& entry) const;
  /// An archive of files, not packed. @param files  Each its name, and its bytes.
  [[nodiscard]] static std::string of(const std::vector<std::pair<std::string, std::string>>& files);

 private:
  std::string_view file_;
  std::vector<Entry> entries_;
};

}  // namespace haptics
