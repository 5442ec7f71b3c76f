#pragma once

#include "common/wire/endpoint.h"

namespace haptics::stress {

/// A client process that sends a byte at a time, reads a byte at a time, and subscribes to all telemetry there is. It
/// connects again whenever the server has had enough. Until SIGKILL.
[[noreturn]] void runDribbler(const Endpoint& server);

}  // namespace haptics::stress
