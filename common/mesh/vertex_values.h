#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/canonical_bytes.h"

namespace haptics {

/// One number for each vertex of a mesh, in its canonical numbering: canonical bytes, which are what is hashed and sent:
/// "HVTX", u32 version 1, u64 count, then a float32 each, all little-endian.
[[nodiscard]] std::string encodeVertexValues(std::span<const float> values);

/// Refused: wrong magic or version, a size that does not match the count (checked before anything is allocated), a count
/// of 0 or above kMaxVertices, a number that is not finite or below 0.
[[nodiscard]] Result<std::vector<float>> decodeVertexValues(std::string_view bytes);

/// The same bytes where the values lie, none of which is -0; with their SHA-256.
[[nodiscard]] CanonicalBytes canonicalBytes(const std::vector<float>& vertexValues);
[[nodiscard]] ContentHash hashOf(const std::vector<float>& vertexValues);

}  // namespace haptics
