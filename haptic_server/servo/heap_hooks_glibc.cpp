// Stands in front of glibc's heap, so that every allocation in the process passes the tripwire and the meter of its work.
#include <malloc.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "common/interruption/work_meter.h"
#include "haptic_server/servo/allocation_tripwire.h"

namespace {

/// 0 where nobody wants to know.
std::int64_t sizeOf(void* block) noexcept {
  return haptics::WorkMeter::current() == nullptr ? 0 : static_cast<std::int64_t>(malloc_usable_size(block));
}

void* counted(void* block) noexcept {
  haptics::WorkMeter::heapGrew(sizeOf(block));
  return block;
}

}  // namespace

#pragma GCC visibility push(default)  // for shared libraries too
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) noexcept {
  haptics::AllocationTripwire::heapTouched();
  return counted(__libc_malloc(size));
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  haptics::AllocationTripwire::heapTouched();
  return counted(__libc_calloc(count, size));
}

void* realloc(void* block, std::size_t size) noexcept {
  haptics::AllocationTripwire::heapTouched();
  const std::int64_t before = sizeOf(block);
  void* const moved = __libc_realloc(block, size);
  if (moved != nullptr || size == 0) haptics::WorkMeter::heapGrew(sizeOf(moved) - before);
  return moved;
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  haptics::AllocationTripwire::heapTouched();
  return counted(__libc_memalign(alignment, size));
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return memalign(alignment, size); }

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  *block = memalign(alignment, size);
  return *block ? 0 : ENOMEM;
}

void free(void* block) noexcept {
  if (block) haptics::AllocationTripwire::heapTouched();
  haptics::WorkMeter::heapGrew(-sizeOf(block));
  __libc_free(block);
}

}  // extern "C"
#pragma GCC visibility pop
