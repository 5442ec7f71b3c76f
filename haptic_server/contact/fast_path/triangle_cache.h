#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic_server/contact/fast_path/cached_triangle.h"

namespace haptics {

/// Polygons that the IHIP may come over in the coming tick, looked up and worked out before the HIP's place is known. A
/// tick that hops to one of them waits for neither. Follows from the meshes alone: what is not known costs time, but not
/// a bit of what is felt.
class TriangleCache {
 public:
  /// Of two polygons that fall on one place the later is known. Fewer forget more; more take memory (320 bytes each) that
  /// is hardly used.
  static constexpr std::size_t kSlots = 256;

  /// Before a surface ends: another one may be where it was.
  void clear() noexcept {
    for (CachedTriangle& polygon : polygons_) polygon.clear();
  }
  /// Works it out, or asks the caches for it where it is known. Not of a surface that crosses itself: over that no tick may
  /// hop unguarded.
  void insert(const CollisionMesh& surface, std::uint32_t triangle) noexcept {
    if (surface.anySelfIntersecting()) return;
    CachedTriangle& polygon = polygons_[triangle % kSlots];
    if (!polygon.is(surface, triangle)) return polygon.load(surface, triangle);
    constexpr std::size_t kCacheLine_bytes = 64;
    const char* const bytes = reinterpret_cast<const char*>(&polygon);
    for (std::size_t i = 0; i < sizeof polygon; i += kCacheLine_bytes) __builtin_prefetch(bytes + i);
  }
  /// Null when it is not known.
  [[nodiscard]] const CachedTriangle* find(const CollisionMesh& surface, std::uint32_t triangle) const noexcept {
    const CachedTriangle& polygon = polygons_[triangle % kSlots];
    return polygon.is(surface, triangle) ? &polygon : nullptr;
  }

 private:
  std::array<CachedTriangle, kSlots> polygons_;
};

}  // namespace haptics
