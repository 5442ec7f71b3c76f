#pragma once

#include <cstddef>
#include <memory>

#include "common/wire/transport.h"
#include "tests/sim/random.h"
#include "tests/sim/virtual_time.h"

namespace haptics::sim {

/// What the network between the server and one client is like at the moment.
struct Weather {
  double latency_ms = 5;
  double jitter_ms = 2;
  double bytesPerSecond = 1e7;
  double stallChance = 0;            ///< Of each piece of bytes: a lost packet, and what is behind it waits too.
  double stall_ms = 300;             ///< At most.
  std::size_t largestPiece = 16384;  ///< Bytes arrive in pieces of 1 to this.
};

/// One connection through a bad network: ordered bytes in arbitrary cuts, late, and lost when the line breaks. The two
/// ends are Transports as TCP's are: what an end has sent may still arrive after it is gone.
class Line {
 public:
  /// Time, chance and weather outlive the line's last event.
  Line(VirtualTime& time, Random& random, const Weather& weather);

  /// Each to be taken once.
  [[nodiscard]] std::unique_ptr<Transport> takeClient();
  [[nodiscard]] std::unique_ptr<Transport> takeServer();

  /// What is on the way is lost; each end hears of it within half a second.
  void cut();
  /// Nothing passes any more and nobody is told.
  void fallSilent();
  /// While it does not, what arrives waits, and once the window is full the server's bytes wait too.
  void clientReads(bool reads);

  struct Wire;

 private:
  std::shared_ptr<Wire> wire_;
};

}  // namespace haptics::sim
