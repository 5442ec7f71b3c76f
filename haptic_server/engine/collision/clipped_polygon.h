#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {

/// A flat part of a body, clipped; room for as many corners as its sides may give it. Not initialised.
struct ClippedPolygon {
  std::size_t count;
  std::array<PolytopeContact::Point, 2 * Polytope::kMaxOfFace> points;

  /// Units of clipTo(), a side.
  static constexpr std::int64_t kUnits = 60;

  [[nodiscard]] std::span<const PolytopeContact::Point> all() const noexcept { return std::span(points).first(count); }
  /// The corners of a loop, numbered.
  template <class PlaceOf>
  void fill(std::size_t size, PlaceOf placeOf) noexcept {
    for (count = 0; count < size; ++count) points[count] = {static_cast<std::uint32_t>(count), placeOf(count), {}, 0};
  }
  /// Keeps what is behind a plane (Sutherland and Hodgman 1974).
  /// @param side  Which one it is, for the ids.
  void clip(Vec3 normal, double offset_m, std::uint32_t side) noexcept {
    if (std::ranges::all_of(std::span(points).first(count),
                            [&](const PolytopeContact::Point& p) { return glm::dot(normal, p.on) <= offset_m; }))
      return;
    ClippedPolygon kept;
    kept.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const PolytopeContact::Point &from = points[i], &to = points[i + 1 == count ? 0 : i + 1];
      const double beyondFrom = glm::dot(normal, from.on) - offset_m, beyondTo = glm::dot(normal, to.on) - offset_m;
      if (beyondFrom <= 0 && kept.count < kept.points.size()) kept.points[kept.count++] = from;
      if ((beyondFrom <= 0) == (beyondTo <= 0) || kept.count == kept.points.size()) continue;
      PolytopeContact::Point& at = kept.points[kept.count++];
      at.id =
          (1 + side) << 12U | (beyondFrom <= 0 ? from.id : to.id) % 64 << 6U | (beyondFrom <= 0 ? to.id : from.id) % 64;
      at.on = from.on + beyondFrom / (beyondFrom - beyondTo) * (to.on - from.on);
    }
    std::copy_n(kept.points.begin(), kept.count, points.begin());
    count = kept.count;
  }
  /// Keeps what is within a loop of corners, counterclockwise about the normal.
  template <class PlaceOf>
  void clipTo(std::size_t size, PlaceOf placeOf, Vec3 normal) noexcept {
    for (std::size_t i = 0; i < size && count > 0; ++i) {
      const Vec3 from = placeOf(i), to = placeOf(i + 1 == size ? 0 : i + 1);
      const Vec3 outward = glm::cross(to - from, normal);
      clip(outward, glm::dot(outward, from), static_cast<std::uint32_t>(i));
    }
  }
};

}  // namespace haptics
