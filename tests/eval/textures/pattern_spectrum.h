#pragma once

#include <cstdint>

#include "common/surface/sampled_field.h"

// Spectra in the plane of fields that are computed, for what theory says of them.
namespace haptics::eval {

/// Waves to a tile's side at which the field's power is: mean of the wave number's length weighted by the power of
/// each ring, around the ring that has most of it.
[[nodiscard]] double ringOf(const SampledField& field);

/// Spots s of random places and strengths have |S|^2 as their expected power spectrum (van Wijk 1991). For the spot
/// (1 - r^2)^2, half as high at half its width, |S| is J_3(u) / u^3, u the wave vector times the radii. Sum of all
/// differences, ring of u by ring, of the mean power of as many fields as it takes against that, of all power.
[[nodiscard]] double spotSpectrumDifference(std::uint32_t cells, double elongation, std::uint32_t seed);

}  // namespace haptics::eval
