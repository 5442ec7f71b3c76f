#include "haptic_server/net/datagram_paths.h"

#include <openssl/rand.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "common/wire/udp.h"

namespace haptics {

std::string DatagramPaths::add(std::uint64_t connection, std::string host) {
  std::array<unsigned char, kCookieBytes> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
    throw std::runtime_error("the system gives no random numbers");
  }
  std::string cookie(random.begin(), random.end());
  remove(connection);
  byCookie_[cookie] = connection;
  paths_[connection] = Path{cookie, std::move(host), 0, 0};
  return cookie;
}

void DatagramPaths::remove(std::uint64_t connection) {
  const auto at = paths_.find(connection);
  if (at == paths_.end()) return;
  byCookie_.erase(at->second.cookie);
  paths_.erase(at);
}

void DatagramPaths::received(std::span<const char> bytes, const Endpoint& from, std::uint64_t now_ns) {
  v1::Datagram datagram;
  const bool isComplete =
      bytes.size() <= kMaxDatagramBytes && datagram.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  const auto at = isComplete ? byCookie_.find(datagram.cookie()) : byCookie_.end();
  if (at == byCookie_.end() || paths_[at->second].host != from.host || datagram.has_telemetry()) {
    ++forged_;
    return;
  }
  Path& path = paths_[at->second];
  path.port = from.port;
  path.heard_ns = now_ns;
  if (!datagram.has_hand_target()) return send_(bytes, from);
  const v1::HandTarget& target = datagram.hand_target();
  if (target.hand() >= kMaxLedHands || target.number() <= path.newestTarget[target.hand()]) return;
  path.newestTarget[target.hand()] = target.number();
  onTarget_(at->second, target);
}

bool DatagramPaths::send(std::uint64_t connection, const v1::Telemetry& telemetry, std::uint64_t now_ns) {
  const auto at = paths_.find(connection);
  if (at == paths_.end() || at->second.port == 0 || now_ns - at->second.heard_ns > kOpenFor_ns) return false;
  out_.set_cookie(at->second.cookie);
  *out_.mutable_telemetry() = telemetry;
  if (out_.ByteSizeLong() > kMaxDatagramBytes) return false;
  out_.SerializeToString(&bytes_);
  send_(bytes_, {at->second.host, at->second.port});
  return true;
}

}  // namespace haptics
