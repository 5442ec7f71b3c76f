#pragma once

#include <algorithm>
#include <cstddef>

#include "common/interruption/interruption.h"

namespace haptics {

/// Makes a vector `count` long, as resize() does, with an interruption point in each megabyte or so: the system takes a
/// second to clear a gigabyte.
template <class Vector>
void growTo(Vector& vector, std::size_t count, const typename Vector::value_type& value = {}) {
  constexpr std::size_t kPiece = std::max<std::size_t>(1, (1U << 20) / sizeof value);
  vector.reserve(count);
  while (vector.size() < count) {
    interruptionPoint();
    vector.resize(std::min(count, vector.size() + kPiece), value);
  }
}

/// Calls work(i) for 0 <= i < count, with an interruption point in each few thousand.
template <class Work>
void forEach(std::size_t count, Work work) {
  constexpr std::size_t kPiece = 4096;
  for (std::size_t begin = 0; begin < count; begin += kPiece) {
    interruptionPoint();
    const std::size_t end = std::min(count, begin + kPiece);
    for (std::size_t i = begin; i < end; ++i) work(i);
  }
}

}  // namespace haptics
