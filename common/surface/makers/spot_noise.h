#pragma once

#include "common/scene/surface_edits.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// Spots of random strength, up or down, at random places, added up (van Wijk 1991): the spot's shape sets the texture's
/// spectrum, a long one makes a grain along x. A spot is (1 - r^2)^2, a tile's side / cells wide where it is half as
/// high. Periodic, mean 0, scaled to reach 1 or -1. The same samples on every machine (basic operations alone).
[[nodiscard]] SampledField spotNoise(const SpotNoiseSource& source);

}  // namespace haptics
