#pragma once

#include <functional>
#include <memory>

#include "common/error/error.h"
#include "common/wire/endpoint.h"
#include "common/wire/event_loop.h"
#include "common/wire/transport.h"

// TCP as a Transport: no Nagle delay; the system holds little unsent data, so that backlog() tells soon that the link
// is slow and newest-only messages stay new; reads are bounded, so that a fast sender cannot fill the memory.
namespace haptics {

/// Accepts connections until it is destroyed.
class TcpListener {
 public:
  using Accepted = std::function<void(std::unique_ptr<Transport>)>;

  /// Refused, naming the address: a port in use, an address that is not of this machine, a port that needs privilege.
  [[nodiscard]] static Result<std::unique_ptr<TcpListener>> open(EventLoop& loop, const Endpoint& address,
                                                                 Accepted accepted);
  ~TcpListener();

  [[nodiscard]] Endpoint local() const;  ///< With the port that the system chose, where 0 was asked for.

 private:
  struct State;
  explicit TcpListener(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

/// One attempt to connect; destroying it abandons the attempt silently.
class TcpConnector {
 public:
  using Done = std::function<void(Result<std::unique_ptr<Transport>>)>;

  /// `done` is called once, never from within; it may destroy the connector.
  TcpConnector(EventLoop& loop, const Endpoint& server, Done done);
  ~TcpConnector();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace haptics
