#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "common/wire/transport.h"

namespace haptics::test {

/// One end of a connection, started, and what it has seen.
struct TransportEnd {
  explicit TransportEnd(std::unique_ptr<Transport> t) : transport(std::move(t)) {
    transport->start({.received =
                          [this](std::span<const char> bytes) {
                            heard.append(bytes.data(), bytes.size());
                            if (then) then();
                          },
                      .drained = [this] { ++drained; },
                      .closed =
                          [this](const std::string& why) {
                            ++closed;
                            reason = why;
                          }});
  }

  std::unique_ptr<Transport> transport;
  std::function<void()> then;  ///< Called when something was heard; may be empty.
  std::string heard, reason;
  int drained = 0, closed = 0;
};

}  // namespace haptics::test
