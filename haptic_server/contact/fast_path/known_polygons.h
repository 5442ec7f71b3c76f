#pragma once

#include <xmmintrin.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic_server/contact/fast_path/held_polygon.h"

namespace haptics {

/// Polygons that the IHIP may come over in the coming tick, looked up and worked out before the HIP's place is known. A
/// tick that hops to one of them waits for neither. Follows from the meshes alone: what is not known costs time, but not
/// a bit of what is felt.
class KnownPolygons {
 public:
  /// Of two polygons that fall on one place the later is known. Fewer forget more; more take memory (320 bytes each) that
  /// is hardly used.
  static constexpr std::size_t kPlaces = 256;

  /// Before a surface ends: another one may be where it was.
  void forget() noexcept {
    for (HeldPolygon& polygon : polygons_) polygon.forget();
  }
  /// Works it out, or asks the caches for it where it is known. Not of a surface that crosses itself: over that no tick may
  /// hop unguarded.
  void learn(const Surface& surface, std::uint32_t triangle) noexcept {
    if (surface.anyCrossed()) return;
    HeldPolygon& polygon = polygons_[triangle % kPlaces];
    if (!polygon.is(surface, triangle)) return polygon.become(surface, triangle);
    constexpr std::size_t kCacheLine_bytes = 64;
    const char* const bytes = reinterpret_cast<const char*>(&polygon);
    for (std::size_t i = 0; i < sizeof polygon; i += kCacheLine_bytes) _mm_prefetch(bytes + i, _MM_HINT_T0);
  }
  /// Null when it is not known.
  [[nodiscard]] const HeldPolygon* find(const Surface& surface, std::uint32_t triangle) const noexcept {
    const HeldPolygon& polygon = polygons_[triangle % kPlaces];
    return polygon.is(surface, triangle) ? &polygon : nullptr;
  }

 private:
  std::array<HeldPolygon, kPlaces> polygons_;
};

}  // namespace haptics
