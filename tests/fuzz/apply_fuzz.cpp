// Transactions into the sequencer, and its commits into a replica: both sides end with the same root, whatever was asked.

#include "common/wire/convert.h"
#include "haptic_server/scene/sequencer.h"
#include "tests/fuzz/pieces.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics {
namespace {

constexpr SessionId kSession = 9;

void run(std::span<const std::uint8_t> input) {
  test::BoxResolver resolver;
  Sequencer sequencer(5, resolver);
  SceneVersion replica;
  std::uint64_t seq = 0;
  fuzz::forEachPiece(input, [&](std::span<const std::uint8_t> piece) {
    v1::Transaction message;
    if (!message.ParseFromArray(piece.data(), static_cast<int>(piece.size()))) return;
    fuzz::keepSmall(message);
    const auto transaction = fromWire(message);
    if (!transaction) return fuzz::require(!transaction.error().reason.empty(), "a refusal has a reason");
    const ContentHash before = sequencer.history()->version.root();
    const EditOutcome outcome = sequencer.submit(kSession, ++seq, *transaction);
    const auto* accepted = std::get_if<std::shared_ptr<const AcceptedEdit>>(&outcome);
    if (accepted == nullptr) {
      return fuzz::require(sequencer.history()->version.root() == before, "what is not accepted changes nothing");
    }
    const Commit& commit = (*accepted)->commit;
    v1::Commit sent;
    toWire(commit, sent);
    const auto arrived = fromWire(sent);
    fuzz::require(arrived.has_value(), "a commit can be read again");
    auto next = replica.apply(*arrived);
    fuzz::require(next.has_value() && next->root() == commit.root, "the replica stands where the server stands");
    replica = *std::move(next);
    const EditOutcome again = sequencer.submit(kSession, seq, *transaction);
    const auto* same = std::get_if<std::shared_ptr<const AcceptedEdit>>(&again);
    fuzz::require(same != nullptr && (*same)->commit.revision == commit.revision, "an edit is applied once");
    fuzz::require(sequencer.history()->version.root() == replica.root(), "an edit is applied once");
  });
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  haptics::run({data, size});
  return 0;
}
