#pragma once

#include <functional>
#include <vector>

#include "tests/eval/report.h"
#include "tests/eval/stability/limits.h"

namespace haptics::eval {

/// By simulation of the plant under a spring that holds both ways, without encoder and force limit: largest K (N/m) with
/// which a disturbance dies out.
[[nodiscard]] double simulatedLimit_N_per_m(const SampledLoop& loop);

/// The spring's length (m) with the device at x (m) and a stiffness (N/m), tick by tick, on what gives way under it.
using Stand = std::function<std::function<double(double, double)>()>;
/// The same on such a thing, made anew for each try; at most `most_N_per_m`. @param softest_N_per_m  Of its own springs.
[[nodiscard]] double simulatedLimit_N_per_m(const SampledLoop& loop, const Stand& stand, double softest_N_per_m,
                                            double most_N_per_m);

/// By simulation: largest displacement (m) from which the device comes back to rest.
[[nodiscard]] double simulatedRadius_m(const SampledLoop& loop, double coulombFriction_N, double stiffness_N_per_m);

/// The simulated plant against the formulas of the literature and the eigenvalues of the sampled system.
[[nodiscard]] std::vector<Record> compareWithTheory();

}  // namespace haptics::eval
