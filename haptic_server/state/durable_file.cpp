#include "haptic_server/state/durable_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr int kPermissions = 0666;  // less the umask

tl::unexpected<Error> failed(const fs::path& path) {
  return refused(path.string(), std::generic_category().message(errno));
}

Result<FileHandle> open(const fs::path& path, int flags) {
  FileHandle file(::open(path.c_str(), flags | O_CLOEXEC, kPermissions));
  if (!file) return failed(path);
  return file;
}

}  // namespace

Result<void> writeDurably(const FileHandle& file, std::string_view bytes, std::size_t offset) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return failed("");
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::size_t>(written);
  }
  if (::fdatasync(file.descriptor()) != 0) return failed("");
  return {};
}

Result<void> truncateDurably(const FileHandle& file, std::size_t size) {
  if (::ftruncate(file.descriptor(), static_cast<off_t>(size)) != 0 || ::fdatasync(file.descriptor()) != 0)
    return failed("");
  return {};
}

Result<FileHandle> createDurably(const fs::path& path, std::string_view bytes) {
  auto file = open(path, O_RDWR | O_CREAT | O_TRUNC);
  if (!file) return file;
  if (auto written = writeDurably(*file, bytes, 0); !written) {
    ::unlink(path.c_str());  // gives the space back
    return tl::unexpected(std::move(written).error().within(path.string()));
  }
  return file;
}

Result<void> renameDurably(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return failed(from);
  return syncFolder(to.parent_path());
}

Result<FileHandle> openForWriting(const fs::path& path) { return open(path, O_RDWR); }

Result<void> makeFolderDurably(const fs::path& folder) {
  if (fs::is_directory(folder)) return {};
  if (auto made = makeFolderDurably(folder.parent_path()); !made) return made;
  std::error_code error;
  if (!fs::create_directory(folder, error) && error) return refused(folder.string(), error.message());
  return syncFolder(folder.parent_path());
}

Result<void> syncFolder(const fs::path& folder) {
  const auto opened = open(folder, O_RDONLY | O_DIRECTORY);
  if (!opened) return tl::unexpected(opened.error());
  if (::fsync(opened->descriptor()) != 0) return failed(folder);
  return {};
}

Result<FileHandle> lockFile(const fs::path& path) {
  auto file = open(path, O_RDWR | O_CREAT);
  if (!file) return file;
  if (::flock(file->descriptor(), LOCK_EX | LOCK_NB) == 0) return file;
  if (errno == EWOULDBLOCK) return refused(path.string(), "another server uses this folder");
  return failed(path);
}

}  // namespace haptics
