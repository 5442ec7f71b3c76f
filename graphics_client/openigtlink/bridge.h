#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "common/credentials/credentials.h"
#include "common/error/error.h"
#include "common/wire/endpoint.h"

namespace haptics::igtl {

struct BridgeOptions {
  Endpoint server;
  std::optional<ClientCredentials> credentials{};  ///< Of the server.
  Endpoint listen;
  double rate_Hz = 60;
  /// Gets a line whenever something changes.
  std::function<void(const std::string&)> say;
};

/// Speaks OpenIGTLink to who connects, until `stop` is set: sends the server's session, and takes objects' poses; reconnects to
/// the server by itself. Refused: what somebody has to change first.
[[nodiscard]] Result<void> runBridge(const BridgeOptions& options, const std::atomic<bool>& stop);

}  // namespace haptics::igtl
