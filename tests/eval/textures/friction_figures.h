#pragma once

#include <cstdint>
#include <vector>

#include "tests/eval/report.h"

namespace haptics::eval {

/// Friction (section 4.2 of the paper) in the production step, positions given: coefficients recovered from the force,
/// chatter and drift under the trembling of an encoder, maps and sandpaper, together with a texture.
[[nodiscard]] std::vector<Record> measureFriction(std::uint64_t seed);

}  // namespace haptics::eval
