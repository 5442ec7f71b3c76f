#pragma once

#include <array>
#include <cstdint>

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// A polygon with all that a tick on it reads. Follows from the mesh alone, which never changes.
struct CachedTriangle {
  const CollisionMesh* surface = nullptr;  ///< Null when it is empty.
  std::uint32_t triangle = kNoTriangle;
  std::uint32_t canonical = kNoTriangle;
  std::array<std::uint32_t, 3> neighbour{};  ///< As TriangleRecord::neighbour(),
  std::array<std::uint32_t, 3> vertex{};     ///< and TriangleRecord::vertexAt().
  Prism prism;
  Double4 normal{};           ///< As Prism::normal(),
  double perSquaredNormal{};  ///< 1 / Prism::squaredNormal(),
  double perNormal{};         ///< the root of that,
  Double4 unitNormal{};       ///< Prism::unitNormal().

  [[nodiscard]] bool is(const CollisionMesh& s, std::uint32_t t) const noexcept {
    return surface == &s && triangle == t;
  }
  void clear() noexcept { surface = nullptr; }

  /// As TriangleRecord::cornerOf().
  [[nodiscard]] int cornerOf(std::uint32_t v) const noexcept {
    return vertex[0] == v ? 0 : vertex[1] == v ? 1 : vertex[2] == v ? 2 : -1;
  }

  /// Sets the geometry and the neighbours.
  void take(const TriangleRecord& record) noexcept {
    for (int k = 0; k < 3; ++k) neighbour[static_cast<std::size_t>(k)] = record.neighbour(k);
    vertex = record.vertex;
    canonical = record.canonical();
    prism = Prism(record);
  }
  /// Sets the identity and what follows from the geometry.
  void deriveFromPrism(const CollisionMesh& s, std::uint32_t t) noexcept {
    surface = &s;
    triangle = t;
    normal = prism.normal();
    const double squared = prism.squaredNormal();
    const double length = std::sqrt(squared);
    perSquaredNormal = 1 / squared;
    perNormal = 1 / length;
    unitNormal = normal / broadcast(length);
  }
  [[gnu::noinline]] void load(const CollisionMesh& s, std::uint32_t t) noexcept {
    take(s.triangle(t));
    deriveFromPrism(s, t);
  }

  /// As Prism::foot().
  [[nodiscard]] Double4 foot(Double4 h, double height) const noexcept {
    return h - normal * broadcast(height * perSquaredNormal);
  }
  /// As Prism::distance().
  [[nodiscard]] double distance(double height) const noexcept { return std::abs(height) * perNormal; }
};

}  // namespace haptics
