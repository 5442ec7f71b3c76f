#pragma once

#include <nlohmann/json.hpp>

#include "tests/stress/run.h"

namespace haptics::stress {

/// stress.json: what was found, the limits, and whether all of them hold.
[[nodiscard]] nlohmann::ordered_json makeReport(const RunResult& result);

}  // namespace haptics::stress
