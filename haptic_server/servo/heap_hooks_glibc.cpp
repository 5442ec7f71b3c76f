// Stands in front of glibc's heap, so that every allocation in the process passes the tripwire.
#include <cerrno>
#include <cstddef>

#include "haptic_server/servo/allocation_tripwire.h"

#pragma GCC visibility push(default)  // for shared libraries too
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  haptics::AllocationTripwire::heapTouched();
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  haptics::AllocationTripwire::heapTouched();
  return __libc_calloc(count, size);
}

void* realloc(void* block, std::size_t size) {
  haptics::AllocationTripwire::heapTouched();
  return __libc_realloc(block, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  haptics::AllocationTripwire::heapTouched();
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  *block = memalign(alignment, size);
  return *block ? 0 : ENOMEM;
}

void free(void* block) {
  if (block) haptics::AllocationTripwire::heapTouched();
  __libc_free(block);
}

}  // extern "C"
#pragma GCC visibility pop
