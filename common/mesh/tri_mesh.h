#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/hash/content_hash.h"
#include "common/maths/vec.h"

namespace haptics {

using TriangleIndices = std::array<std::uint32_t, 3>;

/// An indexed triangle mesh in *canonical order*: the order that is hashed, sent over the wire and numbered by
/// telemetry. Vertices in metres, object frame; triangles counter-clockwise seen from outside.
///
/// Invariants (established by canonicalise(), checked on arrival from the wire by checkMesh()): all vertices finite,
/// none is -0; all indices in range; at least one triangle; no triangle names a vertex twice; every vertex is used.
struct TriMesh {
  std::vector<Vec3f> vertices;
  std::vector<TriangleIndices> triangles;

  bool operator==(const TriMesh&) const = default;
};

/// Largest mesh that the system takes: above, 32-bit indices and the wire's sizes would not hold.
inline constexpr std::uint64_t kMaxTriangles = 50'000'000;
inline constexpr std::uint64_t kMaxVertices = 50'000'000;

}  // namespace haptics
