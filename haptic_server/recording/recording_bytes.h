#pragma once

#include <concepts>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/process/file_handle.h"

namespace haptics {

/// A recording's bytes: in memory, which outlives this, or a file's, which are read as they are looked at. A file that is
/// cut short meanwhile ends there. Copies are of the same.
class RecordingBytes {
 public:
  template <std::convertible_to<std::string_view> Text>
  RecordingBytes(const Text& memory) : memory_(memory), size_(memory_.size()) {}
  /// Refused with an empty field: missing, not a regular file, unreadable.
  [[nodiscard]] static Result<RecordingBytes> open(const std::filesystem::path& path);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }  ///< When it was opened.
  /// Appends up to so many bytes from this offset on: fewer where there are no more. Refused with an empty field: they
  /// cannot be read.
  [[nodiscard]] Result<void> read(std::size_t offset, std::size_t size, std::string& out) const;

 private:
  RecordingBytes(std::shared_ptr<const FileHandle> file, std::size_t size) : file_(std::move(file)), size_(size) {}
  std::string_view memory_;
  std::shared_ptr<const FileHandle> file_;  // null: it is in memory
  std::size_t size_ = 0;
};

}  // namespace haptics
