#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/process/file_handle.h"

namespace haptics {

/// Largest file that is read, in bytes: a binary STL of kMaxTriangles takes 2.5 GB.
inline constexpr std::uintmax_t kMaxFileSize = 4'000'000'000;

/// Does not wait for whoever may be at the other end. Refused with an empty field: missing, not a regular file, empty,
/// larger than kMaxFileSize, unreadable.
[[nodiscard]] Result<FileHandle> openFile(const std::filesystem::path& path);

/// By which a change of a file is noticed, without reading it. Links are followed; one that is not there has the same
/// stamp each time.
struct FileStamp {
  std::filesystem::path file;
  std::filesystem::file_time_type changed;
  std::uintmax_t size = 0;  ///< Bytes.
  auto operator<=>(const FileStamp&) const = default;
};
[[nodiscard]] FileStamp stampOf(const std::filesystem::path& file);

/// All of it. Refused as above.
[[nodiscard]] Result<std::string> readFile(const FileHandle& file);
[[nodiscard]] Result<std::string> readFile(const std::filesystem::path& path);

/// Largest file of an asset's canonical bytes, in bytes: as much as all assets of a scene take.
inline constexpr std::uintmax_t kMaxAssetFileSize = 512U << 20;
/// All of it, likewise; refused as well: larger than that.
[[nodiscard]] Result<std::string> readAssetFile(const std::filesystem::path& path);

/// Whole or not at all, also where the machine stops or the disk is full: the bytes are on the disk before the file, as
/// PATH.part until then, has its name. Errors name the file.
[[nodiscard]] Result<void> writeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace haptics
