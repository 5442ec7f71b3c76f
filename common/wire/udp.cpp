#include "common/wire/udp.h"

#include <array>
#include <asio/buffer.hpp>
#include <asio/ip/udp.hpp>
#include <utility>

#include "common/wire/event_loop_context.h"

namespace haptics {

using asio::ip::udp;

struct DatagramSocket::State : std::enable_shared_from_this<DatagramSocket::State> {
  State(asio::io_context& io, Received received_) : socket(io), received(std::move(received_)) {}

  void receive() {
    socket.async_receive_from(
        asio::buffer(input), from, [self = shared_from_this()](const std::error_code& error, std::size_t size) {
          if (!self->socket.is_open()) return;
          // Errors tell of datagrams sent before (nobody listens there): nothing to act on.
          try {
            if (!error)
              self->received({self->input.data(), size}, {self->from.address().to_string(), self->from.port()});
          } catch (...) {
            self->receive();
            throw;
          }
          self->receive();
        });
  }

  udp::socket socket;
  Received received;
  udp::endpoint from;
  std::array<char, kMaxDatagramBytes + 1> input{};
};

DatagramSocket::DatagramSocket(std::shared_ptr<State> state) : state_(std::move(state)) {}

DatagramSocket::~DatagramSocket() {
  std::error_code ignored;
  state_->socket.close(ignored);
}

Result<std::unique_ptr<DatagramSocket>> DatagramSocket::open(EventLoop& loop, const Endpoint& local,
                                                             Received received) {
  auto state = std::make_shared<State>(loop.context().io, std::move(received));
  std::error_code error;
  const udp::endpoint at(asio::ip::make_address(local.host, error), local.port);
  if (!error) state->socket.open(at.protocol(), error);
  if (!error) state->socket.bind(at, error);
  if (!error) state->socket.non_blocking(true, error);
  if (error) return refused("UDP " + local.text(), error.message());
  state->receive();
  return std::unique_ptr<DatagramSocket>(new DatagramSocket(std::move(state)));
}

Result<std::unique_ptr<DatagramSocket>> DatagramSocket::towards(EventLoop& loop, const Endpoint& peer,
                                                                Received received) {
  const bool ipv6 = peer.host.find(':') != std::string::npos;
  return open(loop, {ipv6 ? "::" : "0.0.0.0", 0}, std::move(received));
}

void DatagramSocket::send(std::span<const char> bytes, const Endpoint& to) {
  std::error_code ignored;
  const auto address = asio::ip::make_address(to.host, ignored);
  if (!ignored) state_->socket.send_to(asio::buffer(bytes.data(), bytes.size()), {address, to.port}, 0, ignored);
}

Endpoint DatagramSocket::local() const {
  std::error_code ignored;
  const udp::endpoint at = state_->socket.local_endpoint(ignored);
  return {at.address().to_string(), at.port()};
}

}  // namespace haptics
