// What comes by NATS, to who reads a published session: stored messages, then live ones, some honest, some of whoever may publish
// there. A client calls no scene equal that is not.

#include <gtest/gtest.h>

#include <optional>

#include "graphics_client/audience/published_messages.h"
#include "graphics_client/audience/relayed_session.h"
#include "graphics_client/mirror/client_limits.h"
#include "graphics_client/mirror/client_session.h"
#include "tests/common/wire/memory_link.h"
#include "tests/fuzz/pieces.h"
#include "tests/graphics_client/audience/published_session.h"

namespace haptics {
namespace {

using Piece = std::span<const std::uint8_t>;

enum Action { kStoreSnapshot, kStoreCommit, kDamageStored, kLiveCommit, kLiveSample, kHonestCommit, kChunk, kActions };

int actionOf(Piece piece) { return piece[0] % kActions; }
std::string bytesOf(Piece piece) { return {piece.begin() + 1, piece.end()}; }

/// The stream as it is read: what was published honestly, with what the input adds to it and damages of it.
StoredSession stored(PublishedSession& published, Piece input) {
  published.storeSnapshot();
  published.store(published.subjects.commit, published.commit("c").SerializeAsString());
  std::vector<StoredMessage> messages = published.stored;
  fuzz::forEachPiece(input, [&](Piece piece) {
    if (piece.empty()) return;
    const int action = actionOf(piece);
    if (action == kStoreSnapshot || action == kStoreCommit) {
      const std::string& subject = action == kStoreSnapshot ? published.subjects.snapshot : published.subjects.commit;
      messages.push_back({messages.size() + 1, subject, bytesOf(piece)});
    }
    if (action != kDamageStored || piece.size() < 4) return;
    std::string& bytes = messages[piece[1] % messages.size()].bytes;
    if (!bytes.empty()) bytes[piece[2] % bytes.size()] ^= static_cast<char>(piece[3]);
  });
  auto read = published.read(messages);
  return read ? *std::move(read) : published.read().value();
}

class Watcher {
 public:
  explicit Watcher(Piece input)
      : session_(
            stored(published_, input), [this](v1::Envelope& envelope) { send(envelope); },
            [](const ContentHash&, std::uint64_t) {}),
        serverEnd_(link_.takeServer()),
        clientEnd_(link_.takeClient()) {
    serverEnd_->start(
        {.received = [this](std::span<const char> bytes) { answer(bytes); }, .drained = {}, .closed = {}});
    clientEnd_->start({.received = [this](std::span<const char> bytes) { client_.received(bytes, kNow_ns); },
                       .drained = {},
                       .closed = {}});
    client_.connected(*clientEnd_, kNow_ns);
    check();
    fuzz::forEachPiece(input, [this](Piece piece) {
      if (piece.empty() || isOver_) return;
      take(piece);
      check();
    });
  }

 private:
  void take(Piece piece) {
    switch (actionOf(piece)) {
      case kLiveCommit:
        return note(session_.commit(bytesOf(piece)));
      case kLiveSample:
        return note(session_.sample(bytesOf(piece)));
      case kHonestCommit:
        return note(session_.commit(published_.commit("n" + std::to_string(++added_)).SerializeAsString()));
      case kChunk:
        (void)readAssetChunk(bytesOf(piece), published_.server.scene.objects().front()->mesh, piece[0] / kActions);
        return;
      default:
        return;
    }
  }

  void note(const Result<void>& taken) { isOver_ = !taken; }

  void answer(std::span<const char> bytes) {
    decoder_.feed(bytes);
    for (auto next = decoder_.next(); next && *next; next = decoder_.next()) {
      fuzz::require(session_.fromClient(**next).has_value(), "a client's own messages are taken");
    }
  }

  void send(v1::Envelope& envelope) {
    envelope.set_protocol_version(kProtocolVersion);
    std::string frame;
    if (appendFrame(frame, envelope)) serverEnd_->send(std::move(frame));
  }

  void check() {
    link_.settle();
    const MirrorView view = client_.view(kNow_ns);
    fuzz::require(view.scene->objects().size() <= kMaxHeldObjects, "objects stay within their limit");
    if (!view.hashesEqual) return;
    const auto own = recomputedRoot(view);
    fuzz::require(own && *own == view.serverRoot, "hashes that are called equal are equal");
  }

  static constexpr std::uint64_t kNow_ns = 1'000'000'000;
  PublishedSession published_;
  MemoryLink link_;
  RelayedSession session_;
  std::unique_ptr<Transport> serverEnd_, clientEnd_;
  FrameDecoder decoder_;
  int added_ = 0;
  bool isOver_ = false;
  ClientSession client_{
      {.session = 77, .clientName = "test", .token = "", .telemetryRate_Hz = 60, .fetchAssets = true}};
};

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  GTEST_FLAG_SET(throw_on_failure, true);
  haptics::Watcher watcher({data, size});
  return 0;
}
