#include "haptic_server/state/durable_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <mutex>
#include <system_error>
#include <utility>

#include "common/mesh/file_bytes.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

constexpr int kPermissions = 0666;  // less the umask
/// One for a file and one for its folder, and as many again that others may snatch meanwhile.
constexpr std::size_t kSpareDescriptors = 4;

tl::unexpected<Error> failed(const fs::path& path) {
  return refused(path.string(), std::generic_category().message(errno));
}

Result<void> outcome(int result, const fs::path& path) {
  if (result != 0) return failed(path);
  return {};
}

class SystemFile final : public FileSystem::File {
 public:
  explicit SystemFile(FileHandle handle) : handle_(std::move(handle)) {}

  Result<void> write(std::string_view bytes, std::size_t offset) override {
    while (!bytes.empty()) {
      const ssize_t written = ::pwrite(handle_.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return failed("");
      bytes.remove_prefix(static_cast<std::size_t>(written));
      offset += static_cast<std::size_t>(written);
    }
    return {};
  }
  Result<void> truncate(std::size_t size) override {
    return outcome(::ftruncate(handle_.descriptor(), static_cast<off_t>(size)), "");
  }
  Result<void> sync() override { return outcome(::fdatasync(handle_.descriptor()), ""); }

 private:
  FileHandle handle_;
};

class SystemFiles final : public FileSystem {
 public:
  SystemFiles() { refill(); }

  Result<std::string> read(const fs::path& path) override {
    const auto file = openHandle(path, O_RDONLY | O_NONBLOCK);
    if (!file) return tl::unexpected(file.error());
    struct stat status {};
    if (::fstat(file->descriptor(), &status) != 0) return failed(path);
    if (!S_ISREG(status.st_mode)) return refused(path.string(), "is not a regular file");
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size > kMaxFileSize) return refused(path.string(), "has more than " + std::to_string(kMaxFileSize) + " bytes");
    std::string bytes(size, '\0');
    std::size_t done = 0;
    while (done < size) {
      const ssize_t got = ::pread(file->descriptor(), bytes.data() + done, size - done, static_cast<off_t>(done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return failed(path);
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
  }
  Result<OpenFile> open(const fs::path& path) override { return openFile(path, O_RDWR); }
  Result<OpenFile> create(const fs::path& path) override { return openFile(path, O_RDWR | O_CREAT | O_TRUNC); }
  Result<void> rename(const fs::path& from, const fs::path& to) override {
    return outcome(::rename(from.c_str(), to.c_str()), from);
  }
  Result<void> remove(const fs::path& path) override { return outcome(::unlink(path.c_str()), path); }
  Result<void> allocate(const fs::path& path, std::size_t bytes) override {
    const auto file = openHandle(path, O_RDWR | O_CREAT | O_TRUNC);
    if (!file) return tl::unexpected(file.error());
    if (const int error = ::posix_fallocate(file->descriptor(), 0, static_cast<off_t>(bytes)); error != 0) {
      ::unlink(path.c_str());
      return refused(path.string(), std::generic_category().message(error));
    }
    return {};
  }
  Result<std::vector<Entry>> list(const fs::path& folder) override {
    std::error_code error;
    std::vector<Entry> entries;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      struct stat status {};
      if (::stat(at->path().c_str(), &status) != 0) continue;
      entries.push_back({at->path().filename().string(),
                         S_ISREG(status.st_mode) ? static_cast<std::size_t>(status.st_size) : 0, status.st_mtime});
    }
    if (error) return refused(folder.string(), error.message());
    return entries;
  }
  bool isFolder(const fs::path& path) override {
    std::error_code error;
    return fs::is_directory(path, error);
  }
  Result<void> makeFolder(const fs::path& path) override {
    std::error_code error;
    if (!fs::create_directory(path, error) && error) return refused(path.string(), error.message());
    return {};
  }
  Result<void> syncFolder(const fs::path& folder) override {
    const auto opened = openHandle(folder, O_RDONLY | O_DIRECTORY);
    if (!opened) return tl::unexpected(opened.error());
    return outcome(::fsync(opened->descriptor()), folder);
  }
  Result<OpenFile> lock(const fs::path& path) override {
    auto file = openHandle(path, O_RDWR | O_CREAT);
    if (!file) file = openHandle(path, O_RDONLY);
    if (!file) file = openHandle(path.parent_path(), O_RDONLY | O_DIRECTORY);
    if (!file) return tl::unexpected(file.error());
    if (::flock(file->descriptor(), LOCK_EX | LOCK_NB) == 0) return std::make_unique<SystemFile>(*std::move(file));
    if (errno == EWOULDBLOCK) return OpenFile();
    return failed(path);
  }
  std::size_t free_bytes(const fs::path& folder) override {
    struct statvfs status {};
    if (::statvfs(folder.c_str(), &status) != 0) return 0;
    return static_cast<std::size_t>(status.f_bavail) * status.f_frsize;
  }
  std::int64_t now_s() override { return std::time(nullptr); }

 private:
  std::mutex mutex_;  // guards the next
  std::vector<FileHandle> spares_;

  void refill() {
    const std::lock_guard lock(mutex_);
    while (spares_.size() < kSpareDescriptors) {
      FileHandle spare(::open("/dev/null", O_RDONLY | O_CLOEXEC));
      if (!spare) return;
      spares_.push_back(std::move(spare));
    }
  }
  Result<FileHandle> openHandle(const fs::path& path, int flags) {
    const auto tryOnce = [&] { return FileHandle(::open(path.c_str(), flags | O_CLOEXEC, kPermissions)); };
    refill();
    FileHandle file = tryOnce();
    if (!file && (errno == EMFILE || errno == ENFILE)) {
      const std::lock_guard lock(mutex_);  // until it is open: no other of these takes what is given back
      spares_.clear();
      file = tryOnce();
    }
    if (!file) return failed(path);
    return file;
  }
  Result<OpenFile> openFile(const fs::path& path, int flags) {
    auto file = openHandle(path, flags);
    if (!file) return tl::unexpected(file.error());
    return std::make_unique<SystemFile>(*std::move(file));
  }
};

}  // namespace

std::shared_ptr<FileSystem> systemFiles() { return std::make_shared<SystemFiles>(); }

Result<void> writeDurably(FileSystem::File& file, std::string_view bytes, std::size_t offset) {
  if (auto written = file.write(bytes, offset); !written) return written;
  return file.sync();
}

Result<FileSystem::OpenFile> createDurably(FileSystem& files, const fs::path& path, std::string_view bytes) {
  auto file = files.create(path);
  if (!file) return file;
  if (auto written = writeDurably(**file, bytes, 0); !written) {
    files.remove(path);  // gives the space back
    return tl::unexpected(std::move(written).error().within(path.string()));
  }
  return file;
}

Result<void> renameDurably(FileSystem& files, const fs::path& from, const fs::path& to) {
  if (auto renamed = files.rename(from, to); !renamed) return renamed;
  return files.syncFolder(to.parent_path());
}

Result<void> makeFolderDurably(FileSystem& files, const fs::path& folder) {
  if (files.isFolder(folder)) return {};
  if (auto made = makeFolderDurably(files, folder.parent_path()); !made) return made;
  if (auto made = files.makeFolder(folder); !made) return made;
  return files.syncFolder(folder.parent_path());
}

}  // namespace haptics
