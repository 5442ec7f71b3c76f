#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"

namespace haptics {

using TriangleIndices = std::array<std::uint32_t, 3>;

/// An indexed triangle mesh in *canonical order*: the order that is hashed, sent over the wire and numbered by
/// telemetry. Vertices in metres, object frame; triangles counter-clockwise seen from outside.
///
/// Invariants (established by canonicalise(), checked on arrival from the wire by checkMesh()): all vertices finite,
/// none is -0; all indices in range; at least one triangle; no triangle names a vertex twice or is without area; every
/// vertex is used.
struct TriMesh {
  std::vector<Vec3f> vertices;
  std::vector<TriangleIndices> triangles;

  bool operator==(const TriMesh&) const = default;
};

/// Largest mesh that the system takes: above, 32-bit indices and the wire's sizes would not hold.
inline constexpr std::uint64_t kMaxTriangles = 50'000'000;
inline constexpr std::uint64_t kMaxVertices = 50'000'000;

/// True when the cross product of two sides, computed in double, is not zero: the triangle has a normal.
[[nodiscard]] bool hasArea(Vec3f a, Vec3f b, Vec3f c) noexcept;

/// Refused: a breach of TriMesh's invariants, naming the first vertex or triangle at fault ("vertices[7]").
[[nodiscard]] Result<void> checkMesh(const TriMesh& mesh);

}  // namespace haptics
