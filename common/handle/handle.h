#pragma once

#include <memory>

namespace haptics {

template <auto kFree>
struct FreeWith {
  template <class T>
  void operator()(T* object) const noexcept {
    kFree(object);
  }
};

/// Owns what a C library made, and gives it back by `kFree`.
template <class T, auto kFree>
using Handle = std::unique_ptr<T, FreeWith<kFree>>;

}  // namespace haptics
