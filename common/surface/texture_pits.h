#pragma once

#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// Whether a texture's pits are drawn as pits and felt as bumps: Eq. (4a) of the paper, as printed, pulls uphill where
/// h < 0.
[[nodiscard]] inline bool pitsAreFeltAsBumps(const Texture& texture, const ScalarField& field) {
  return texture.literal && texture.law == Texture::Law::kHo1999 && field.lowest() < 0;
}

}  // namespace haptics
