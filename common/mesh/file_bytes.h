#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "common/error/error.h"

namespace haptics {

/// Largest file that is read, in bytes: a binary STL of kMaxTriangles takes 2.5 GB.
inline constexpr std::uintmax_t kMaxFileSize = 4'000'000'000;

/// A file that is open for reading; closed with it.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) noexcept : descriptor_(descriptor) {}
  OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~OpenFile();

  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

/// Does not wait for whoever may be at the other end. Refused with an empty field: missing, not a regular file, empty,
/// larger than kMaxFileSize, unreadable.
[[nodiscard]] Result<OpenFile> openFile(const std::filesystem::path& path);

/// All of it. Refused as above.
[[nodiscard]] Result<std::string> readFile(const OpenFile& file);
[[nodiscard]] Result<std::string> readFile(const std::filesystem::path& path);

}  // namespace haptics
