#pragma once

#include <filesystem>

#include "tests/stress/findings.h"
#include "tests/stress/network.h"
#include "tests/stress/run_plan.h"

namespace haptics::stress {

struct RunOptions {
  std::filesystem::path out;
  bool relay = false;  ///< Also where namespaces could be made.
  bool viewer = true;  ///< The real graphics_client too, where there is a display or Xvfb.
};

struct Disturbance {
  std::uint64_t time_ns = 0;
  std::string what;
};

struct RunResult {
  RunPlan plan{};
  std::string network{};
  NetworkCounts counts{};
  Evidence evidence{};
  std::vector<Disturbance> disturbances{};
  bool serverEndedWell = false;
};

/// Starts everything, disturbs it, lets it come to rest, stops it. Throws std::runtime_error where it cannot.
[[nodiscard]] RunResult run(RunPlan plan, const RunOptions& options);

}  // namespace haptics::stress
