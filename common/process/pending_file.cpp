#include "common/process/pending_file.h"

#include <strings.h>

#include <system_error>
#include <utility>

namespace haptics {

Result<void> checkEnding(const std::filesystem::path& file, const std::string& ending) {
  const std::string has = file.extension().string();
  if (has.empty() || strcasecmp(has.c_str(), ending.c_str()) == 0) return {};
  return refused("", file.string() + ": ends with " + has + ", but what is written is a " + ending + "; name it so");
}

PendingFile::PendingFile(const std::filesystem::path& file) : file_(file), place_(file) {
  std::error_code none;
  const std::filesystem::path target = std::filesystem::weakly_canonical(file, none);
  if (none || (std::filesystem::exists(target, none) && !std::filesystem::is_regular_file(target, none))) return;
  target_ = target;
  place_ = target.string() + ".part";
}

PendingFile::~PendingFile() {
  std::error_code ignored;
  if (!target_.empty()) std::filesystem::remove(place_, ignored);
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : file_(std::move(other.file_)), place_(std::move(other.place_)), target_(std::exchange(other.target_, {})) {}

Result<void> PendingFile::finish() {
  if (target_.empty()) return {};
  std::error_code failure;
  std::filesystem::rename(place_, target_, failure);
  if (failure) return refused(file_.string(), "cannot be written: " + failure.message());
  target_.clear();
  return {};
}

}  // namespace haptics
