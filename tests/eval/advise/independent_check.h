#pragma once

#include <map>
#include <string>

#include "haptic_server/simplification/force_difference.h"
#include "tests/eval/advise/loaded_scene.h"

namespace haptics::eval {

/// A scene against another one, object by object, by strokes in directions and with presses (0.7 to 1.3 N) that are drawn
/// from the seed: in the production step with every detail of the surfaces, rigid and at rest. Objects that no hand gets to
/// from above, and tools, are left out.
[[nodiscard]] std::map<std::string, ForceDifference> checkedAgainst(const std::vector<LoadedObject>& scene,
                                                                    const std::vector<LoadedObject>& original,
                                                                    std::uint64_t seed);

}  // namespace haptics::eval
