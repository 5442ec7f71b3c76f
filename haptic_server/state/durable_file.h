#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/process/file_handle.h"

// Files whose bytes are on the disk, as far as the disk says so, when a function has returned without an error. Errors
// name the path, where the function is given one, and the system's reason.
namespace haptics {

/// What a state folder asks of the file system, and no more: a test's own loses power, fills up and fails. One thread.
class FileSystem {
 public:
  class File {
   public:
    virtual ~File() = default;
    /// All of the bytes; on an error some of them may be there.
    [[nodiscard]] virtual Result<void> write(std::string_view bytes, std::size_t offset) = 0;
    [[nodiscard]] virtual Result<void> truncate(std::size_t size) = 0;
    /// Waits for the disk. After an error it is not known what is on it, nor will a second wait tell.
    [[nodiscard]] virtual Result<void> sync() = 0;
  };
  using OpenFile = std::unique_ptr<File>;
  struct Entry {
    std::string name;
    std::size_t size = 0;  ///< Bytes; 0 of a folder.
    std::int64_t changed_s = 0;
  };

  virtual ~FileSystem() = default;
  /// The whole file; an empty one too. Refused: more than kMaxFileSize bytes.
  [[nodiscard]] virtual Result<std::string> read(const std::filesystem::path& path) = 0;
  [[nodiscard]] virtual Result<OpenFile> open(const std::filesystem::path& path) = 0;
  /// A new file instead of one with this name.
  [[nodiscard]] virtual Result<OpenFile> create(const std::filesystem::path& path) = 0;
  /// Within a folder, instead of what has the other name. At every moment it is the one or the other.
  [[nodiscard]] virtual Result<void> rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  virtual Result<void> remove(const std::filesystem::path& path) = 0;
  /// A new file that takes so much space, whatever is written later.
  [[nodiscard]] virtual Result<void> allocate(const std::filesystem::path& path, std::size_t bytes) = 0;
  [[nodiscard]] virtual Result<std::vector<Entry>> list(const std::filesystem::path& folder) = 0;
  [[nodiscard]] virtual bool isFolder(const std::filesystem::path& path) = 0;
  [[nodiscard]] virtual Result<void> makeFolder(const std::filesystem::path& path) = 0;
  /// Makes the names in a folder durable.
  [[nodiscard]] virtual Result<void> syncFolder(const std::filesystem::path& folder) = 0;
  /// Holds the lock of a folder, by a file of this name or, where there can be none, by the folder itself, until the
  /// handle or the process is gone. Nothing: another process has it.
  [[nodiscard]] virtual Result<OpenFile> lock(const std::filesystem::path& path) = 0;
  [[nodiscard]] virtual std::size_t free_bytes(const std::filesystem::path& folder) = 0;
  [[nodiscard]] virtual std::int64_t now_s() = 0;  ///< As in Entry.
};

/// The system's own. Some descriptors are held in reserve, for files that are needed when the process has no others
/// left.
[[nodiscard]] std::shared_ptr<FileSystem> systemFiles();

/// Writes at this offset of the file, and waits for the disk.
[[nodiscard]] Result<void> writeDurably(FileSystem::File& file, std::string_view bytes, std::size_t offset);
/// A new file with these bytes, instead of one with this name. Its name is not durable before renameDurably(). On an
/// error it is gone.
[[nodiscard]] Result<FileSystem::OpenFile> createDurably(FileSystem& files, const std::filesystem::path& path,
                                                         std::string_view bytes);
/// Within a folder. At every moment, also after a crash, `to` is either what it was or what `from` was.
[[nodiscard]] Result<void> renameDurably(FileSystem& files, const std::filesystem::path& from,
                                         const std::filesystem::path& to);
/// The folder, and those above it, where there is none.
[[nodiscard]] Result<void> makeFolderDurably(FileSystem& files, const std::filesystem::path& folder);

}  // namespace haptics
