#pragma once

#include <span>

#include "common/maths/vec.h"

namespace haptics::eval {

/// Root mean square (N) of what a signal of forces, one every period_s, holds above a frequency. A Hann window keeps its
/// ends from counting as a jump. 0 for fewer than 16 samples.
[[nodiscard]] double rmsAbove(double frequency_Hz, std::span<const Vec3> force_N, double period_s);

}  // namespace haptics::eval
