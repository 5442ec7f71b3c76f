#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>

#include "haptic_server/net/rate_limit.h"

namespace haptics {

/// How many TLS handshakes a host may begin: each costs the network thread about a millisecond before anyone has said who
/// they are, and telemetry to all others waits for it.
class HandshakeLimit {
 public:
  static constexpr double kPerSecond = 20;        ///< More from one host: the telemetry of others becomes uneven.
  static constexpr double kBurst = 100;           ///< More than the clients of a server that restarts.
  static constexpr std::size_t kMaxHosts = 1024;  ///< Remembered; beyond, all are forgotten.

  [[nodiscard]] bool allow(const std::string& host, std::uint64_t now_ns) {
    if (hosts_.size() >= kMaxHosts && !hosts_.contains(host)) hosts_.clear();
    return hosts_.try_emplace(host, kPerSecond, kBurst).first->second.allow(now_ns);
  }

 private:
  std::unordered_map<std::string, RateLimit> hosts_;
};

}  // namespace haptics
