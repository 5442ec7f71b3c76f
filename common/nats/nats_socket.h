#pragma once

#include <nats/nats.h>

#include <cstdint>
#include <stop_token>
#include <string>

namespace haptics {

/// The socket of a connection that libnats has made. The library does not tell it, so that it is found as what is new among the
/// process's sockets; and it needs to be known, for libnats 3.4 waits without end for a server that falls silent once it has
/// said who it is, and keeps as much of a message as a server announces.
class NatsSocket {
 public:
  NatsSocket() = default;
  NatsSocket(int descriptor, std::uint64_t inode) : descriptor_(descriptor), inode_(inode) {}
  auto operator<=>(const NatsSocket&) const = default;

  /// Bytes that came by it; 0: it is not known, or closed.
  [[nodiscard]] std::uint64_t received_bytes() const;
  /// Whoever waits for it learns that the server has gone.
  void shutDown() const;

 private:
  int descriptor_ = -1;
  std::uint64_t inode_ = 0;

  [[nodiscard]] bool isOpen() const;
};

/// natsConnection_Connect() that gives each server 1.5 s, and all up at a stop.
/// @param urls    Those of the options.
/// @param socket  Gets the connection's.
[[nodiscard]] natsStatus connectToNats(natsConnection*& made, natsOptions& options, const std::string& urls,
                                       const std::stop_token& stop, NatsSocket& socket);

}  // namespace haptics
