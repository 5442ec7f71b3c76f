#pragma once

#include <memory>
#include <utility>

#include "common/wire/event_loop.h"
#include "common/wire/transport.h"

namespace haptics {

/// Two transports in one process, joined: each is used on the thread of its own loop, and outlived by it. What is sent at
/// one end is handed to the other loop; it counts as backlog until the other end has taken it.
[[nodiscard]] std::pair<std::unique_ptr<Transport>, std::unique_ptr<Transport>> linkLoops(EventLoop& first,
                                                                                          EventLoop& second);

}  // namespace haptics
