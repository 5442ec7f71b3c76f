#pragma once

#include <vector>

#include "common/scene/effect_properties.h"
#include "graphics_client/viewer/palette.h"

namespace haptics {

/// What an effect is drawn as, in its frame: points 2i and 2i + 1 are the ends of a segment. The place that it pulls to, from how
/// far it takes hold, its region, where it pushes; of lines and planes without end a piece about their point. Empty where it acts
/// alike everywhere, and so has no place.
[[nodiscard]] std::vector<Vec3> effectLines(const Effect& effect);

/// By what it does to the hand: pulls, keeps out, drags, or acts by itself.
[[nodiscard]] palette::Shade effectShade(Effect::Kind kind);

}  // namespace haptics
