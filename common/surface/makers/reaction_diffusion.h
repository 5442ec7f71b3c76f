#pragma once

#include "common/scene/surface_edits.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// Spots or stripes as two substances make them that react with each other and diffuse at different rates (Turing 1952;
/// Turk 1991; Witkin & Kass 1991): the concentration of the first, periodic, mean 0, scaled to reach 1 or -1. The
/// equations are those of Barrio, Varea, Aragon & Maini (1999), of which linear theory tells the wavelength beforehand: as
/// many spots or stripes as asked for, within a tenth, where Turk's own are counted afterwards. The same samples
/// on every machine (basic operations alone). Takes about a millisecond times cells squared: not for a servo thread.
[[nodiscard]] SampledField reactionDiffusion(const ReactionDiffusionSource& source);

}  // namespace haptics
