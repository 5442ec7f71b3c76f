#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <vector>

namespace haptics {

/// Allocates from pages of 2 MiB where the system gives them (madvise), so that a tick that touches a few random cache
/// lines of a large mesh does not also miss the address translation. Small arrays are only aligned to a cache line.
template <class T>
struct LargePageAllocator {
  using value_type = T;
  static constexpr std::size_t kPage_bytes = std::size_t{2} << 20;
  static constexpr std::size_t kCacheLine_bytes = 64;

  LargePageAllocator() = default;
  template <class U>
  explicit LargePageAllocator(const LargePageAllocator<U>&) {}

  [[nodiscard]] T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* memory = ::operator new(bytes, alignment(bytes));
    if (bytes >= kPage_bytes) ::madvise(memory, bytes, MADV_HUGEPAGE);  // advice: nothing depends on its success
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) { ::operator delete(memory, alignment(count * sizeof(T))); }

  bool operator==(const LargePageAllocator&) const = default;

 private:
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{bytes >= kPage_bytes ? kPage_bytes : kCacheLine_bytes};
  }
};

template <class T>
using LargePageVector = std::vector<T, LargePageAllocator<T>>;

}  // namespace haptics
