#pragma once

#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {

/// Edits of random scenes under a HIP that stands still, so that every change of the force is the edit's: bodies that
/// overlap, that yield, that are textured, that have friction, that pass through themselves. Adds its measures to those
/// of `result`.
/// @return Whether the force on the device took no step of more than 0.035 N in a tick, the IHIP was inside of nothing
/// in the end, by winding number, and every edit was rendered in full within 1 s.
[[nodiscard]] bool editUnderRestingHip(Renderer& method, Random& random, SceneResult& result);

}  // namespace haptics::eval
