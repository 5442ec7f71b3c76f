#pragma once

#include <libdeflate.h>

#include <memory>
#include <new>

namespace haptics {

struct FreeInflater {
  void operator()(libdeflate_decompressor* inflater) const noexcept { libdeflate_free_decompressor(inflater); }
};
using Inflater = std::unique_ptr<libdeflate_decompressor, FreeInflater>;

inline Inflater makeInflater() {
  Inflater inflater(libdeflate_alloc_decompressor());
  if (!inflater) throw std::bad_alloc();
  return inflater;
}

/// Most bytes that one of deflate stands for.
inline constexpr std::size_t kMaxInflation = 1032;

}  // namespace haptics
