#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "common/wire/endpoint.h"
#include "tests/stress/cast.h"

namespace haptics::stress {

/// Two clients on the far side of the plan's network lead a hand each, which together pinch a brick, lift it by 40 mm and hold
/// it for the plan's time, while viewers look on. The report, whose "pass" says whether it was held, and contacts were shown
/// where they are. A run that fails while the machine held a process up for so long that hands let go is repeated.
/// Throws std::runtime_error where it cannot run.
[[nodiscard]] nlohmann::ordered_json runPinched(RunPlan plan, const CastOptions& options);

struct HandLeaderOptions {
  Endpoint server;
  std::size_t hand = 0;
  std::uint64_t began_ns = 0;  ///< Monotonic: when both set out.
};

/// One of the two clients, in a process of its own. It says on standard output when it leads.
void runHandLeader(const HandLeaderOptions& options);

}  // namespace haptics::stress
