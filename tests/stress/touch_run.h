#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/stress/run_plan.h"

namespace haptics::stress {

struct TouchRunOptions {
  std::filesystem::path out;
  bool relay = false;  ///< Also where namespaces could be made.
  int viewers = 4;     ///< Every second one has its telemetry by UDP.
};

/// The server's simulated hand pushes bodies and dents soft objects for the plan's time, while viewers look on through the
/// plan's network; then it lets go, a lattice is bent, and all must hold the same shapes. The report, whose "pass" says
/// whether they did and whether contacts were shown where they are. Throws std::runtime_error where it cannot run.
[[nodiscard]] nlohmann::ordered_json runTouched(RunPlan plan, const TouchRunOptions& options);

}  // namespace haptics::stress
