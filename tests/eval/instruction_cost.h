#pragma once

#include <span>

#include "common/maths/vec.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// What a contact tick costs: medians over a stroke. Of a method from outside hot_ns alone, as its process measured it.
struct InstructionCost {
  double hot_ns = 0;        ///< The same stroke again and again; 0 where it was not measured.
  double cold_ns = 0;       ///< Every cache swept before the tick; 0 where it was not measured.
  double instructions = 0;  ///< Mean; 0 where they were not counted.
};

/// @param way  Places of the HIP (world, m): from outside of the surface down to where the stroke begins.
/// @param stroke  In contact throughout.
/// @param countedTicks  At most so many have their instructions counted; 0: none.
[[nodiscard]] InstructionCost instructionCostOf(Renderer& renderer, const std::shared_ptr<const CollisionMesh>& surface,
                                                std::span<const Vec3> way, std::span<const Vec3> stroke, int coldTicks,
                                                int countedTicks);

}  // namespace haptics::eval
