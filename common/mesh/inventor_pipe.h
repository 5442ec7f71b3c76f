#pragma once

#include <cstdint>
#include <type_traits>

namespace haptics {

/// What inventor_reader writes first. After it come three corners a triangle, three float32 each; or, if refused, why,
/// in words.
struct InventorPipeHeader {
  std::uint64_t refused = 0;  ///< 0 or 1.
  std::uint64_t skipped = 0;
  std::uint64_t triangles = 0;
};
static_assert(std::is_trivially_copyable_v<InventorPipeHeader> && sizeof(InventorPipeHeader) == 24);

}  // namespace haptics
