// Messages of a client into a server's session, before and after its Hello.

#include "tests/fuzz/pieces.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics {
namespace {

constexpr std::uint64_t kPause_ns = 50 * test::kMillisecond_ns;  // a second of pauses: heartbeats come due

void run(std::span<const std::uint8_t> input) {
  GTEST_FLAG_SET(throw_on_failure, true);
  test::SessionWorld world;
  (void)world.edit(test::edit(test::add("a"), test::add("b")));
  const std::uint8_t flags = input[0];
  if ((flags & 1) != 0) world.role = Role::kView;
  if ((flags & 2) == 0) world.client.hello();
  world.datagramPathOpen = (flags & 4) != 0;
  world.link.settle();
  std::uint64_t tick = 0;
  fuzz::forEachPiece(input.subspan(1), [&](std::span<const std::uint8_t> piece) {
    v1::Envelope envelope;
    if (!envelope.ParseFromArray(piece.data(), static_cast<int>(piece.size()))) return;
    if (envelope.has_edit_request()) fuzz::keepSmall(*envelope.mutable_edit_request()->mutable_transaction());
    if (envelope.ByteSizeLong() == 0) return;
    world.client.send(envelope);
    TelemetrySample sample;
    sample.tick = ++tick;
    world.session.offerTelemetry(sample);
    world.pass(kPause_ns, kPause_ns);
    world.decideAssets();
  });
  fuzz::require(world.reserved <= world.uploadBudget, "uploads stay within their memory");
  const auto history = world.history();
  if (world.role == Role::kView) {
    fuzz::require(history->version.revision() == 1, "who may only look changes nothing");
  }
  if (world.over) fuzz::require(world.reserved == 0, "the memory of uploads is given back");
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) haptics::run({data, size});
  return 0;
}
