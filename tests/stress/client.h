#pragma once

#include <filesystem>

#include "common/wire/endpoint.h"
#include "tests/stress/run_plan.h"

namespace haptics::stress {

struct ClientOptions {
  int number = 0;
  std::uint64_t life = 0;
  Endpoint server;
  bool datagrams = false;
  bool edits = true;
  std::filesystem::path journal;
};

/// A client process: the production link, which mirrors the scene; during attacks it edits. Ends at SIGTERM.
void runClient(const RunPlan& plan, const ClientOptions& options);

}  // namespace haptics::stress
