#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/stress/run_plan.h"

namespace haptics::stress {

struct AudienceRunOptions {
  std::filesystem::path out, scene;
  int watchers = 500;
  int viewers = 8;  ///< Of them, as WatchersOptions.
  int nodes = 1;    ///< NATS servers; with three a stream's leader is killed in the end.
  int kills = 10;   ///< Of the relay.
};

/// A server's session is published to an audience, in turns with times of half the length without relay and audience, while
/// it is edited and the relay is killed; then the server starts anew, and the stream's leader dies. The report, whose "pass"
/// says whether the servo missed no more ticks with an audience, samples were young, and all watchers held what the server held. Throws
/// std::runtime_error where it cannot run.
[[nodiscard]] nlohmann::ordered_json runAudience(const RunPlan& plan, const AudienceRunOptions& options);

}  // namespace haptics::stress
