#pragma once

#include <cstddef>
#include <span>

#include "common/error/error.h"
#include "common/process/file_handle.h"

namespace haptics {

/// Memory that other processes may map too, by its descriptor, and that outlives this one where they do. Zero to begin with.
class SharedMemory {
 public:
  /// Refused: the system has no more.
  [[nodiscard]] static Result<SharedMemory> make(const char* name, std::size_t size);
  /// Maps memory that another process has made. Refused: no memory of at least this size.
  [[nodiscard]] static Result<SharedMemory> map(FileHandle file, std::size_t minSize);
  ~SharedMemory();
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;

  [[nodiscard]] std::span<std::byte> bytes() const noexcept { return bytes_; }
  [[nodiscard]] int descriptor() const noexcept { return file_.descriptor(); }

 private:
  SharedMemory(FileHandle file, std::span<std::byte> bytes) : file_(std::move(file)), bytes_(bytes) {}
  FileHandle file_;
  std::span<std::byte> bytes_;
};

}  // namespace haptics
