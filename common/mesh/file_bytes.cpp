#include "common/mesh/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>

#include "common/process/pending_file.h"

namespace haptics {
namespace {

tl::unexpected<Error> unreadable(int error) {
  if (error == ENOENT || error == ENOTDIR) return refused("", "there is no such file");
  if (error == EACCES || error == EPERM) return refused("", "cannot be read; check its permissions");
  return refused("", std::string("cannot be read: ") + std::strerror(error));
}

/// Waits for the disk.
bool writeAll(const FileHandle& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file.descriptor(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return fsync(file.descriptor()) == 0 || errno == EINVAL;  // of a pipe
}

/// Size of a file; refused when it is too large to be read.
Result<std::size_t> sizeOf(const FileHandle& file, std::uintmax_t most = kMaxFileSize) {
  struct stat status {};
  if (fstat(file.descriptor(), &status) != 0) return unreadable(errno);
  if (!S_ISREG(status.st_mode)) return refused("", "is not a regular file");
  if (status.st_size == 0) return refused("", "is empty");
  const auto size = static_cast<std::uintmax_t>(status.st_size);
  if (size <= most) return size;
  return refused("", "has " + std::to_string(size) + " bytes; at most " + std::to_string(most) + " are taken");
}

}  // namespace

Result<FileHandle> openFile(const std::filesystem::path& path) {
  FileHandle file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.descriptor() < 0 && errno == ENXIO) return refused("", "is not a regular file");  // a socket
  if (file.descriptor() < 0) return unreadable(errno);
  if (const auto size = sizeOf(file); !size) return tl::unexpected(size.error());
  return file;
}

FileStamp stampOf(const std::filesystem::path& file) {
  std::error_code error;
  return {file, std::filesystem::last_write_time(file, error), std::filesystem::file_size(file, error)};
}

Result<std::string> readFile(const FileHandle& file) {
  const auto size = sizeOf(file);
  if (!size) return tl::unexpected(size.error());
  std::string bytes(*size, '\0');
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t read = pread(file.descriptor(), bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) return unreadable(errno);
    if (read == 0) return refused("", "cannot be read: it became shorter");
    at += static_cast<std::size_t>(read);
  }
  return bytes;
}

Result<std::string> readFile(const std::filesystem::path& path) {
  return openFile(path).and_then([](const FileHandle& file) { return readFile(file); });
}

Result<std::string> readAssetFile(const std::filesystem::path& path) {
  return openFile(path).and_then([](const FileHandle& file) -> Result<std::string> {
    if (const auto size = sizeOf(file, kMaxAssetFileSize); !size) return tl::unexpected(size.error());
    return readFile(file);
  });
}

Result<void> writeFile(const std::filesystem::path& path, std::string_view bytes) {
  constexpr int kPermissions = 0666;  // less the umask
  PendingFile pending(path);
  const FileHandle file(open(pending.place().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kPermissions));
  if (!file || !writeAll(file, bytes)) {
    return refused(path.string(), std::string("cannot be written: ") + std::strerror(errno) +
                                      "; name a file in an existing folder that you may write to");
  }
  const std::filesystem::path folder = pending.place().has_parent_path() ? pending.place().parent_path() : ".";
  if (auto finished = pending.finish(); !finished) return finished;
  const FileHandle names(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (names) (void)fsync(names.descriptor());  // a file system that cannot has written the bytes all the same
  return {};
}

}  // namespace haptics
