#pragma once

#include <filesystem>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// Largest file that is read, in bytes: a binary STL of kMaxTriangles takes 2.5 GB.
inline constexpr std::uintmax_t kMaxFileSize = 4'000'000'000;

/// The whole file. Refused with an empty field: missing, not a regular file, empty, larger than kMaxFileSize,
/// unreadable.
[[nodiscard]] Result<std::string> readFile(const std::filesystem::path& path);

}  // namespace haptics
