#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic_server/engine/contact/fast_path/cached_triangle.h"

namespace haptics {

/// Polygons that the IHIP may reach in the coming tick, computed before the HIP's place is known, so that a tick that
/// hops to one of them does not wait for memory. Follows from the meshes alone.
class TriangleCache {
 public:
  /// Of two polygons with one slot the later is kept. Fewer slots lose more; more take memory (320 bytes each) that is
  /// hardly used.
  static constexpr std::size_t kSlots = 256;

  /// Has to be called before a surface ends, as another one may come to be in its place.
  void clear() noexcept {
    for (CachedTriangle& polygon : polygons_) polygon.clear();
  }
  /// Computes the polygon, or prefetches it where it is there. Not of a surface that crosses itself: over that no tick
  /// may hop unguarded.
  void insert(const CollisionMesh& surface, std::uint32_t triangle) noexcept {
    if (surface.anySelfIntersecting()) return;
    CachedTriangle& polygon = polygons_[triangle % kSlots];
    if (!polygon.is(surface, triangle)) return polygon.load(surface, triangle);
    constexpr std::size_t kCacheLine_bytes = 64;
    const char* const bytes = reinterpret_cast<const char*>(&polygon);
    for (std::size_t i = 0; i < sizeof polygon; i += kCacheLine_bytes) __builtin_prefetch(bytes + i);
  }
  /// Null when it is not there.
  [[nodiscard]] const CachedTriangle* find(const CollisionMesh& surface, std::uint32_t triangle) const noexcept {
    const CachedTriangle& polygon = polygons_[triangle % kSlots];
    return polygon.is(surface, triangle) ? &polygon : nullptr;
  }

 private:
  std::array<CachedTriangle, kSlots> polygons_;
};

}  // namespace haptics
