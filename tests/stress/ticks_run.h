#pragma once

#include <nlohmann/json.hpp>

#include "tests/stress/cast.h"

namespace haptics::stress {

/// A client on the far side of the plan's network has every tick for the plan's time, beside a recording of the server's own.
/// The report, whose "pass" says whether each tick of the recording is in the stream with the same force, bit for bit, or in
/// a gap that the client has named. Throws std::runtime_error where it cannot run.
[[nodiscard]] nlohmann::ordered_json runTicks(RunPlan plan, const CastOptions& options);

}  // namespace haptics::stress
