#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// Where a server listens or is reached.
struct Endpoint {
  std::string host;  ///< A numeric IPv4 or IPv6 address (without brackets) or a host name; never empty.
  std::uint16_t port = 0;

  bool operator==(const Endpoint&) const = default;
  [[nodiscard]] std::string text() const;  ///< "127.0.0.1:7400", "[::1]:7400".
};

/// Reads "HOST:PORT": "127.0.0.1:7400", "[::1]:7400", "localhost:7400" (which is 127.0.0.1, whatever the resolver says)
/// or a host name. Port 0 asks the system for a free one when listening.
[[nodiscard]] Result<Endpoint> parseEndpoint(std::string_view text);

/// Only this machine can reach it: 127.0.0.0/8, ::1. A name other than localhost never counts.
[[nodiscard]] bool isLoopback(const Endpoint& endpoint);

/// Addresses that other machines can reach are refused unless the connections are secured, or the person who starts the
/// server says that the network is trusted (--allow-insecure-lan).
[[nodiscard]] Result<void> checkListenAddress(const Endpoint& endpoint, bool securedOrTrusted);

}  // namespace haptics
