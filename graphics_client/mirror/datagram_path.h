#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/wire/endpoint.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The client's end of telemetry by datagram: knocks at the server with the cookie that its Welcome gave, until the
/// cookie comes back; from then on telemetry may come this way, for as long as something does. No socket and no clock:
/// times in nanoseconds, datagrams in and out by calls. Whatever does not fit is ignored and counted.
class DatagramPath {
 public:
  /// Between knocks, which the server answers: 4 have to be lost in a row before an open path counts as closed.
  static constexpr std::uint64_t kKnock_ns = 250'000'000;
  /// An open path on which nothing came for this long is closed; telemetry then takes the connection. Shorter: closed
  /// by a mere hiccup of the network. Longer: the newest sample is so old.
  static constexpr std::uint64_t kSilence_ns = 1'000'000'000;

  struct Datagram {
    Endpoint to;
    std::string bytes;
  };

  /// A server at `host` said Welcome. A server that offers no datagrams has port 0.
  void welcomed(const v1::Welcome& welcome, std::string host);
  void connectionLost();
  /// What is to be sent now.
  [[nodiscard]] std::optional<Datagram> poll(std::uint64_t now_ns);
  /// This target of a hand, on the open path.
  [[nodiscard]] Datagram withTarget(const v1::HandTarget& target);
  /// The sample in a datagram from the server; most carry one.
  [[nodiscard]] std::optional<v1::Telemetry> take(std::span<const char> bytes, const Endpoint& from,
                                                  std::uint64_t now_ns);

  [[nodiscard]] bool offered() const noexcept { return server_.port != 0; }
  [[nodiscard]] bool open() const noexcept { return open_; }
  [[nodiscard]] std::uint64_t forged() const noexcept { return forged_; }  ///< Datagrams ignored.

 private:
  Endpoint server_;
  std::string cookie_;
  bool open_ = false;
  std::uint64_t targets_ = 0;  // sent
  std::uint64_t heard_ns_ = 0;
  std::uint64_t nextKnock_ns_ = 0;
  std::uint64_t forged_ = 0;
};

}  // namespace haptics
