#pragma once

#include <span>
#include <vector>

#include "common/maths/vec.h"

namespace haptics::eval {

/// How a signal's power (mean square, its mean taken away) is divided among frequencies: element i is that of i periods
/// in the signal's length, up to half as many as it has samples. A Hann window keeps its ends from counting as a jump.
[[nodiscard]] std::vector<double> powerSpectrum(std::span<const double> signal);

/// Periods in the signal's length at the highest peak, between two elements too (a parabola through the logarithms).
/// Nothing below `from` periods counts. 0 where there is no peak.
[[nodiscard]] double peakOf(std::span<const double> spectrum, std::size_t from = 2);

/// Root mean square (N) of what a signal of forces, one every period_s, holds above a frequency. 0 for fewer than 16
/// samples.
[[nodiscard]] double rmsAbove(double frequency_Hz, std::span<const Vec3> force_N, double period_s);

}  // namespace haptics::eval
