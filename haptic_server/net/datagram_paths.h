#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "common/telemetry/hand_command.h"
#include "common/wire/endpoint.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The server's end of telemetry by datagram. Each connection has a cookie; a client that wants datagrams sends it from
/// its socket, again and again, and each time gets it back, which proves the path both ways. Datagrams go only to the
/// host that the connection comes from. Whatever does not fit is ignored and counted. No socket and no clock: times in
/// nanoseconds, datagrams in and out by calls.
class DatagramPaths {
 public:
  /// A path counts as open this long after the client's last sign. Longer: more is sent to who has left.
  static constexpr std::uint64_t kOpenFor_ns = 5'000'000'000;
  static constexpr std::size_t kCookieBytes = 16;

  using Send = std::function<void(std::span<const char> bytes, const Endpoint& to)>;
  using OnTarget = std::function<void(std::uint64_t connection, const v1::HandTarget& target)>;
  /// @param onTarget  For a target of a hand that is newer than those before.
  DatagramPaths(Send send, OnTarget onTarget) : send_(std::move(send)), onTarget_(std::move(onTarget)) {}

  /// The cookie of a connection that comes from `host`, a numeric address.
  [[nodiscard]] std::string add(std::uint64_t connection, std::string host);
  void remove(std::uint64_t connection);
  void received(std::span<const char> bytes, const Endpoint& from, std::uint64_t now_ns);
  /// False where there is no open path, or the sample is too large: it goes over the connection.
  [[nodiscard]] bool send(std::uint64_t connection, const v1::Telemetry& telemetry, std::uint64_t now_ns);
  [[nodiscard]] std::uint64_t forged() const noexcept { return forged_; }  ///< Datagrams ignored.

 private:
  struct Path {
    std::string cookie, host;
    std::uint16_t port = 0;  // 0: the client has not been heard
    std::uint64_t heard_ns = 0;
    std::array<std::uint64_t, kMaxLedHands> newestTarget{};  // of each hand
  };
  Send send_;
  OnTarget onTarget_;
  std::map<std::uint64_t, Path> paths_;            // by connection
  std::map<std::string, std::uint64_t> byCookie_;  // connection
  std::uint64_t forged_ = 0;
  v1::Datagram out_;   // reused
  std::string bytes_;  // reused
};

}  // namespace haptics
