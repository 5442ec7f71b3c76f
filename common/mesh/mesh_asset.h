#pragma once

#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/canonical_bytes.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// The canonical bytes of a mesh, which are what is hashed and sent: "HMSH", u32 version 1, u64 vertex count, u64
/// triangle count, then 3 float32 per vertex and 3 u32 per triangle, all little-endian.
[[nodiscard]] CanonicalBytes canonicalBytes(const TriMesh& mesh);
[[nodiscard]] std::string encodeMesh(const TriMesh& mesh);

/// Refused: wrong magic or version, a size that does not match the counts (checked before anything is allocated),
/// counts above kMaxVertices or kMaxTriangles, and every breach of TriMesh's invariants.
[[nodiscard]] Result<TriMesh> decodeMesh(std::string_view bytes);

/// SHA-256 of encodeMesh(mesh), without making the bytes.
[[nodiscard]] ContentHash hashOf(const TriMesh& mesh);

}  // namespace haptics
