#pragma once

#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/canonical_bytes.h"
#include "common/surface/point_field.h"

namespace haptics {

/// The canonical bytes of a point field, which are what is hashed and sent: "HPTF", u32 version 1, u32 count, float32
/// reach_m, then for each sample x, y, z (object frame, m) and its value, a float32 each, all little-endian.
[[nodiscard]] CanonicalBytes canonicalBytes(const PointField& field);
[[nodiscard]] std::string encodePointField(const PointField& field);

/// Refused: wrong magic or version, a count of 0 or above PointField::kMaxSamples, a size that does not match it
/// (checked before anything is allocated), and whatever PointField::make() refuses.
[[nodiscard]] Result<PointField> decodePointField(std::string_view bytes);

/// SHA-256 of encodePointField(field), without making the bytes.
[[nodiscard]] ContentHash hashOf(const PointField& field);

}  // namespace haptics
