#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic_server/contact/held_polygon.h"

namespace haptics {

/// Polygons that the IHIP may come over in the coming tick, looked up and worked out before the HIP's place is known. A
/// tick that hops to one of them waits for neither. Follows from the meshes alone: what is not known costs time, but not
/// a bit of what is felt.
class KnownPolygons {
 public:
  /// Those around the place where the IHIP is and the one where it will be, and room for as many more. Larger leaves less
  /// of the first level cache (320 bytes each); of two that fall on one place the later is known.
  static constexpr std::size_t kPlaces = 16;

  /// Before a surface ends: another one may be where it was.
  void forget() noexcept {
    for (HeldPolygon& polygon : polygons_) polygon.forget();
  }
  void learn(const Surface& surface, std::uint32_t triangle) noexcept {
    HeldPolygon& polygon = polygons_[triangle % kPlaces];
    if (!polygon.is(surface, triangle)) polygon.become(surface, triangle);
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
