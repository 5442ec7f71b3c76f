#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/maths/vec.h"
#include "common/mesh/canonical_bytes.h"

namespace haptics {

/// Where some of a mesh's vertices are instead of where the mesh has them: absolute values, never increments, so that
/// whoever holds them has the shape however he came by it. Object frame, metres; the mesh's canonical numbering.
///
/// Invariants (checked on arrival from the wire): as many places as vertices, at least one; vertices in ascending order,
/// none twice; finite places within kMaxMoved_m, none -0.
struct MovedVertices {
  static constexpr float kMaxMoved_m = 1e3F;

  std::vector<std::uint32_t> vertex;
  std::vector<Vec3f> place;

  bool operator==(const MovedVertices&) const = default;

  /// Moves them in a mesh's vertices; those that the mesh does not have are left out.
  void moveIn(std::span<Vec3f> vertices) const noexcept;
  /// Nothing for a vertex that is not moved.
  [[nodiscard]] std::optional<Vec3f> placeOf(std::uint32_t vertex) const noexcept;
};

/// Refused: a breach of the invariants.
[[nodiscard]] Result<void> checkMovedVertices(const MovedVertices& moved);

/// The vertices that differ between two shapes of one mesh.
[[nodiscard]] MovedVertices movedBetween(std::span<const Vec3f> before, std::span<const Vec3f> after);

/// Canonical bytes, which are what is hashed and sent: "HMOV", u32 version 1, u64 count, then a u32 for each vertex, then
/// three float32 for each, all little-endian.
[[nodiscard]] CanonicalBytes canonicalBytes(const MovedVertices& moved);
[[nodiscard]] std::string encodeMovedVertices(const MovedVertices& moved);

/// Refused: wrong magic or version, a size that does not match the count (checked before anything is allocated), and every
/// breach of MovedVertices' invariants.
[[nodiscard]] Result<MovedVertices> decodeMovedVertices(std::string_view bytes);

/// SHA-256 of encodeMovedVertices(moved).
[[nodiscard]] ContentHash hashOf(const MovedVertices& moved);

}  // namespace haptics
