#pragma once

#include <filesystem>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// Refused: the name of a file that is to be written ends otherwise than `ending`, such as ".png", which may be in any case. A
/// name without an ending is taken.
[[nodiscard]] Result<void> checkEnding(const std::filesystem::path& file, const std::string& ending);

/// A file that has its name once it is whole; until then what was there stays. It is written as FILE.part, beside the file
/// that links lead to; a pipe or a device is written as it is.
class PendingFile {
 public:
  explicit PendingFile(const std::filesystem::path& file);
  ~PendingFile();  ///< Removes what was not finished.
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&&) = delete;

  /// To be written.
  [[nodiscard]] const std::filesystem::path& place() const noexcept { return place_; }
  /// It is whole. Refused with the file's name: it cannot have it.
  [[nodiscard]] Result<void> finish();

 private:
  std::filesystem::path file_, place_;
  std::filesystem::path target_;  // empty: it is finished, or written as it is
};

}  // namespace haptics
