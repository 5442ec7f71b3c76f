#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "tests/stress/run_plan.h"

namespace haptics::stress {

struct NetworkCounts {
  std::uint64_t packets = 0;  ///< Of IP, or pieces of a stream where it is a relay.
  std::uint64_t lost = 0;
  double late_ms = 0;  ///< 99th percentile: how much later than wanted this machine let packets pass.
};

/// The bad network between server and clients, in this process's threads.
class Network {
 public:
  virtual ~Network() = default;
  [[nodiscard]] virtual std::string kind() const = 0;  ///< For the report.
  /// Where the server is to listen; port 0 until it does.
  [[nodiscard]] virtual std::string serverHost() const = 0;
  /// Where clients reach it, given the port on which it listens.
  [[nodiscard]] virtual std::string clientAddress(std::uint16_t port) = 0;
  /// To be called in a thread or a child process: from then on it is on the server's, or the clients', side.
  virtual void enterServerSide() const = 0;
  virtual void enterClientSide() const = 0;
  /// Packets pass from now on; the plan's clock has begun.
  virtual void start() = 0;
  /// Of the whole; nothing passes any more.
  [[nodiscard]] virtual NetworkCounts counts() = 0;
};

/// Two network namespaces, joined by two TUN devices and a forwarder of IP packets. Null where this process may not make
/// them. `plan` outlives it.
[[nodiscard]] std::unique_ptr<Network> makeNamespaces(const RunPlan& plan);
/// A relay of TCP and UDP on loopback: it delays and cuts; a lost piece of a stream is a stall of one more round trip.
[[nodiscard]] std::unique_ptr<Network> makeRelay(const RunPlan& plan);

}  // namespace haptics::stress
