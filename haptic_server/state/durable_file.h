#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "common/error/error.h"
#include "common/memory/file_handle.h"

// Files whose bytes are on the disk, as far as the disk says so, when a function has returned without an error. Errors
// name the path, where the function is given one, and the system's reason.
namespace haptics {

/// Writes at this offset of the file, and waits for the disk.
[[nodiscard]] Result<void> writeDurably(const FileHandle& file, std::string_view bytes, std::size_t offset);
/// Drops what follows this size, and waits for the disk.
[[nodiscard]] Result<void> truncateDurably(const FileHandle& file, std::size_t size);
/// A new file with these bytes, open for reading and writing, instead of one with this name. Its name is not durable
/// before renameDurably(). On an error it is gone.
[[nodiscard]] Result<FileHandle> createDurably(const std::filesystem::path& path, std::string_view bytes);
/// Within a folder. At every moment, also after a crash, `to` is either what it was or what `from` was.
[[nodiscard]] Result<void> renameDurably(const std::filesystem::path& from, const std::filesystem::path& to);
[[nodiscard]] Result<FileHandle> openForWriting(const std::filesystem::path& path);
/// The folder, and those above it, where there is none.
[[nodiscard]] Result<void> makeFolderDurably(const std::filesystem::path& folder);
/// Makes the names in a folder durable.
[[nodiscard]] Result<void> syncFolder(const std::filesystem::path& folder);
/// Holds this file's lock until the handle or the process is gone. Refused while another process has it.
[[nodiscard]] Result<FileHandle> lockFile(const std::filesystem::path& path);

}  // namespace haptics
