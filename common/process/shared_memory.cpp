#include "common/process/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace haptics {
namespace {

tl::unexpected<Error> failed() { return refused("shared memory", std::generic_category().message(errno)); }

}  // namespace

Result<SharedMemory> SharedMemory::make(const char* name, std::size_t size) {
  FileHandle file(::memfd_create(name, MFD_CLOEXEC));
  // Space that the system has not got is refused here, where a write to it would end the process.
  if (!file || ::ftruncate(file.descriptor(), static_cast<off_t>(size)) != 0) return failed();
  if (::fallocate(file.descriptor(), 0, 0, static_cast<off_t>(size)) != 0) return failed();
  return map(std::move(file), size);
}

Result<SharedMemory> SharedMemory::map(FileHandle file, std::size_t minSize) {
  struct stat about {};
  if (::fstat(file.descriptor(), &about) != 0) return failed();
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size < minSize || size == 0) return refused("shared memory", "is too small");
  void* at = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor(), 0);
  if (at == MAP_FAILED) return failed();
  return SharedMemory(std::move(file), {static_cast<std::byte*>(at), size});
}

SharedMemory::~SharedMemory() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : file_(std::move(other.file_)), bytes_(std::exchange(other.bytes_, {})) {}

SharedMemory& SharedMemory::operator=(SharedMemory&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

}  // namespace haptics
