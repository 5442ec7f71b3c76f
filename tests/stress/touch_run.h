#pragma once

#include <nlohmann/json.hpp>

#include "tests/stress/cast.h"

namespace haptics::stress {

/// The server's simulated hand pushes bodies and dents soft objects for the plan's time, while viewers look on through the
/// plan's network; then it lets go, a lattice is bent, and all must hold the same shapes. The report, whose "pass" says
/// whether they did and whether contacts were shown where they are. Throws std::runtime_error where it cannot run.
[[nodiscard]] nlohmann::ordered_json runTouched(RunPlan plan, const CastOptions& options);

}  // namespace haptics::stress
