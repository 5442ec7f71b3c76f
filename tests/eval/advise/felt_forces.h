#pragma once

#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/simplification/force_difference.h"
#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// The production step along each stroke, before the limit of a device: the contact's force, N, world, in each tick.
[[nodiscard]] std::vector<Forces> forcesIn(const ServoScene& scene, const std::vector<HandStroke>& strokes,
                                           double rate_Hz);

}  // namespace haptics::eval
