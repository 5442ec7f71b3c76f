#include "haptic_server/recording/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "haptic_server/state/durable_file.h"

namespace haptics {
namespace {

tl::unexpected<Error> failed() { return refused("", std::generic_category().message(errno)); }

}  // namespace

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return failed();
  struct stat about {};
  if (::fstat(file.descriptor(), &about) != 0) return failed();
  if (!S_ISREG(about.st_mode)) return refused("", "is not a regular file");
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size == 0) return MappedFile({});
  void* at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
  if (at == MAP_FAILED) return failed();
  return MappedFile({static_cast<const char*>(at), size});
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<char*>(bytes_.data()), bytes_.size());
}

}  // namespace haptics
