#pragma once

#include <filesystem>
#include <string_view>
#include <utility>

#include "common/error/error.h"

namespace haptics {

/// A file's bytes as they were when it was opened, read as they are looked at. A file that is cut short meanwhile ends
/// the process.
class MappedFile {
 public:
  /// Refused with an empty field: missing, not a regular file, unreadable.
  [[nodiscard]] static Result<MappedFile> open(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }

  [[nodiscard]] std::string_view bytes() const noexcept { return bytes_; }

 private:
  explicit MappedFile(std::string_view bytes) : bytes_(bytes) {}
  std::string_view bytes_;
};

}  // namespace haptics
