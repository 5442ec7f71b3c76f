#include "graphics_client/mirror/datagram_path.h"

#include <limits>
#include <utility>

#include "common/wire/udp.h"

namespace haptics {

void DatagramPath::welcomed(const v1::Welcome& welcome, std::string host) {
  connectionLost();
  if (welcome.datagram_port() > std::numeric_limits<std::uint16_t>::max()) return;
  server_ = {std::move(host), static_cast<std::uint16_t>(welcome.datagram_port())};
  cookie_ = welcome.datagram_cookie();
}

void DatagramPath::connectionLost() {
  server_ = {};
  open_ = false;
  nextKnock_ns_ = 0;
}

std::optional<DatagramPath::Datagram> DatagramPath::poll(std::uint64_t now_ns) {
  if (!offered()) return std::nullopt;
  if (now_ns - heard_ns_ > kSilence_ns) open_ = false;
  if (now_ns < nextKnock_ns_) return std::nullopt;
  nextKnock_ns_ = now_ns + kKnock_ns;
  v1::Datagram datagram;
  datagram.set_cookie(cookie_);
  return Datagram{server_, datagram.SerializeAsString()};
}

DatagramPath::Datagram DatagramPath::withTarget(const v1::HandTarget& target) {
  v1::Datagram datagram;
  datagram.set_cookie(cookie_);
  *datagram.mutable_hand_target() = target;
  datagram.mutable_hand_target()->set_number(++targets_);
  return {server_, datagram.SerializeAsString()};
}

std::optional<v1::Telemetry> DatagramPath::take(std::span<const char> bytes, const Endpoint& from,
                                                std::uint64_t now_ns) {
  v1::Datagram datagram;
  if (!offered() || from != server_ || bytes.size() > kMaxDatagramBytes ||
      !datagram.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) || datagram.cookie() != cookie_) {
    ++forged_;
    return std::nullopt;
  }
  heard_ns_ = now_ns;
  open_ = true;
  if (!datagram.has_telemetry()) return std::nullopt;
  return std::move(*datagram.mutable_telemetry());
}

}  // namespace haptics
