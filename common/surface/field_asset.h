#pragma once

#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/canonical_bytes.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// The canonical bytes of a sampled field, which are what is hashed and sent: "HSFD", u32 version 1, u32 width, u32
/// height, then a float32 per sample, row by row, all little-endian.
[[nodiscard]] CanonicalBytes canonicalBytes(const SampledField& field);
[[nodiscard]] std::string encodeField(const SampledField& field);

/// Refused: wrong magic or version, sides out of range, a size that does not match them (checked before anything is
/// allocated), and every value that SampledField refuses.
[[nodiscard]] Result<SampledField> decodeField(std::string_view bytes);

/// SHA-256 of encodeField(field), without making the bytes.
[[nodiscard]] ContentHash hashOf(const SampledField& field);

}  // namespace haptics
