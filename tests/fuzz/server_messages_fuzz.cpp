// Messages of a server into a client's session: whatever comes, the client never takes a scene for the server's that is
// not.

#include "common/wire/convert.h"
#include "tests/fuzz/pieces.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {
namespace {

constexpr std::uint64_t kPause_ns = 50'000'000;

void run(std::span<const std::uint8_t> input) {
  SessionRig rig({.session = 77,
                  .clientName = "fuzz",
                  .token = "",
                  .telemetryRate_Hz = 60,
                  .fetchAssets = true,
                  .datagrams = (input[0] & 1) != 0});
  rig.server.addObject("a");
  if ((input[0] & 2) == 0) {
    rig.join();
  } else {
    rig.connect();
  }
  rig.client.submit(removal(1), {});
  rig.client.requestStatus([](const v1::Status&) {});
  fuzz::forEachPiece(input.subspan(1), [&](std::span<const std::uint8_t> piece) {
    v1::Envelope envelope;
    if (!envelope.ParseFromArray(piece.data(), static_cast<int>(piece.size()))) return;
    if (!rig.server.connected() || !rig.clientEnd) rig.connect();
    rig.server.send(envelope);
    rig.settle();
    rig.advance(kPause_ns);
    (void)rig.client.nextDatagram(rig.now_ns);
  });
  const MirrorView view = rig.view();
  if (view.hashesEqual) {
    const auto own = recomputedRoot(view);
    fuzz::require(own && *own == view.serverRoot, "hashes that are called equal are equal");
  }
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) haptics::run({data, size});
  return 0;
}
