#include "haptic_server/recording/recording_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace haptics {
namespace {

tl::unexpected<Error> unreadable() { return refused("", std::generic_category().message(errno)); }

}  // namespace

Result<RecordingBytes> RecordingBytes::open(const std::filesystem::path& path) {
  FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return unreadable();
  struct stat about {};
  if (::fstat(file.descriptor(), &about) != 0) return unreadable();
  if (!S_ISREG(about.st_mode)) return refused("", "is not a regular file");
  return RecordingBytes(std::make_shared<const FileHandle>(std::move(file)), static_cast<std::size_t>(about.st_size));
}

Result<void> RecordingBytes::read(std::size_t offset, std::size_t size, std::string& out) const {
  size = offset < size_ ? std::min(size, size_ - offset) : 0;
  if (!file_) {
    out += memory_.substr(std::min(offset, memory_.size()), size);
    return {};
  }
  const std::size_t had = out.size();
  out.resize(had + size);
  for (std::size_t at = 0; at < size;) {
    const ssize_t read =
        ::pread(file_->descriptor(), out.data() + had + at, size - at, static_cast<off_t>(offset + at));
    if (read < 0 && errno == EINTR) continue;
    if (read > 0) {
      at += static_cast<std::size_t>(read);
      continue;
    }
    out.resize(had + at);
    return read == 0 ? Result<void>() : unreadable();
  }
  return {};
}

}  // namespace haptics
