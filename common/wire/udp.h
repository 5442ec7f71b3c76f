#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "common/error/error.h"
#include "common/wire/endpoint.h"
#include "common/wire/event_loop.h"

namespace haptics {

/// Fits one packet on every usual path (1,280 bytes is IPv6's least), so that no datagram is lost for its size.
inline constexpr std::size_t kMaxDatagramBytes = 1200;

/// A UDP socket. What the system does not take at once is dropped; so may be what was taken.
class DatagramSocket {
 public:
  /// Up to kMaxDatagramBytes + 1 bytes of each: one more than allowed says that it was larger. Anybody may be `from`.
  using Received = std::function<void(std::span<const char> bytes, const Endpoint& from)>;

  /// `local` is a numeric address; port 0 takes a free one. Refused, naming it: a port in use, an address that is not
  /// of this machine. `received` must not destroy the socket.
  [[nodiscard]] static Result<std::unique_ptr<DatagramSocket>> open(EventLoop& loop, const Endpoint& local,
                                                                    Received received);
  /// A socket that can reach `peer`, a numeric address.
  [[nodiscard]] static Result<std::unique_ptr<DatagramSocket>> towards(EventLoop& loop, const Endpoint& peer,
                                                                       Received received);
  ~DatagramSocket();

  void send(std::span<const char> bytes, const Endpoint& to);
  [[nodiscard]] Endpoint local() const;

 private:
  struct State;
  explicit DatagramSocket(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace haptics
