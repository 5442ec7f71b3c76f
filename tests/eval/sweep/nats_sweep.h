#pragma once

#include <filesystem>
#include <string>

#include "tests/eval/sweep/sweep.h"

namespace haptics::eval {

/// Where a sweep's parts and results lie while they are on their way: a NATS server with JetStream.
struct NatsServer {
  std::string url;                    ///< Such as nats://127.0.0.1:4222; with tls:// the connection is TLS.
  std::filesystem::path credentials;  ///< As readNatsCredentials() takes them; empty: none.
};

/// Gives the parts to the workers of this build, and goes on with their results as if they had been run here. A part that a
/// worker left is given to another one; one that was left three times, or cannot be run, ends the sweep. One that was
/// interrupted goes on where it was when it is started again.
/// @return As Sweep::finish(). Throws std::runtime_error with what NATS or a worker says.
[[nodiscard]] bool runSweepOverNats(Sweep& sweep, const SweepArguments& arguments, const NatsServer& server);

/// Runs parts of sweeps of this build until Ctrl-C. Throws std::runtime_error where only a sweep of another build is there.
void workOnSweeps(const NatsServer& server, const SweepMaker& makeSweep);

}  // namespace haptics::eval
