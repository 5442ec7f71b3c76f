// Datagrams at both ends of the path. A piece's first byte says where it comes from and whether it gets the cookie that
// an attacker cannot know.

#include "common/wire/convert.h"
#include "graphics_client/mirror/datagram_path.h"
#include "haptic_server/net/datagram_paths.h"
#include "tests/fuzz/pieces.h"

namespace haptics {
namespace {

const Endpoint kServer{"10.0.0.1", 7654}, kClient{"10.0.0.2", 5000}, kElsewhere{"10.0.0.3", 5000};

void run(std::span<const std::uint8_t> input) {
  std::uint64_t now_ns = 1'000'000'000'000, tick = 0, given = 0;
  DatagramPath client;
  DatagramPaths server(
      [&](std::span<const char> bytes, const Endpoint& to) {
        fuzz::require(to.host == kClient.host, "nothing goes elsewhere");
        (void)client.take(bytes, kServer, now_ns);
      },
      [](std::uint64_t, const v1::HandTarget& target) { (void)fromWire(target); });
  v1::Welcome welcome;
  welcome.set_datagram_port(kServer.port);
  welcome.set_datagram_cookie(server.add(1, kClient.host));
  client.welcomed(welcome, kServer.host);
  fuzz::forEachPiece(input, [&](std::span<const std::uint8_t> piece) {
    if (piece.empty()) return;
    const std::uint8_t flags = piece[0];
    std::string bytes(piece.begin() + 1, piece.end());
    v1::Datagram datagram;
    if ((flags & 1) != 0 && datagram.ParseFromString(bytes)) {
      datagram.set_cookie(welcome.datagram_cookie());
      bytes = datagram.SerializeAsString();
    }
    const bool elsewhere = (flags & 2) != 0;
    given += 2;
    server.received(bytes, elsewhere ? kElsewhere : kClient, now_ns);
    if (const auto telemetry = client.take(bytes, elsewhere ? kElsewhere : kServer, now_ns)) {
      fuzz::require(!elsewhere, "nothing comes from elsewhere");
      (void)fromWire(*telemetry);
    }
    v1::Telemetry sample;
    sample.set_tick(++tick);
    (void)server.send(1, sample, now_ns);
    (void)client.poll(now_ns);
    now_ns += 300'000'000ULL * (flags >> 2 & 7);
  });
  fuzz::require(server.forged() + client.forged() <= given, "each datagram is counted once");
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  haptics::run({data, size});
  return 0;
}
