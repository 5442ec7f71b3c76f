#include <gmock/gmock.h>

#include <string>

#include "common/wire/convert.h"
#include "graphics_client/mirror/client_limits.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/scene/scene_limits.h"
#include "tests/graphics_client/mirror/session_join_fixture.h"

// Servers that send more than a client holds.
namespace haptics::session_limits_test {
namespace {

using testing::HasSubstr;

static_assert(kMaxHeldObjects >= kMaxServoObjects && kMaxHeldAssets_bytes >= SceneLimits{}.assets_bytes,
              "a client holds every scene that a server holds");

class SessionLimits : public SessionJoin {
 protected:
  /// The session has left, says why, and comes back later; an honest server is then taken up.
  void expectLeft(const std::string& limit) {
    rig_.settle();
    EXPECT_EQ(rig_.connectionsEnded, 1);
    EXPECT_EQ(rig_.view().link, LinkState::kRefused);
    EXPECT_THAT(rig_.view().linkText, HasSubstr(limit));
    EXPECT_EQ(rig_.client.reconnectDelay_ns(), ClientSession::kRefusedDelay_ns);
    rig_.join();
    expectInStep();
  }

  void welcome(const std::function<void(v1::Welcome&)>& change) {
    v1::Envelope envelope;
    envelope.mutable_welcome()->set_epoch(rig_.server.epoch);
    envelope.mutable_welcome()->set_root(rig_.server.scene.root().asBytes());
    change(*envelope.mutable_welcome());
    rig_.connect();
    rig_.server.send(envelope);
  }

  static ObjectRecord object(ObjectId id) {
    ObjectRecord record;
    record.id = id;
    record.name = "object_" + std::to_string(id);
    record.mesh = Hasher().add(id).finish();
    return record;
  }
};

TEST_F(SessionLimits, OfObjectsInASnapshot) {
  rig_.connect();
  rig_.server.welcome(false);
  v1::Envelope begin;
  begin.mutable_snapshot_begin()->set_object_count(kMaxHeldObjects + 1);
  rig_.server.send(begin);
  expectLeft("more than 1024 objects");
}

TEST_F(SessionLimits, OfObjectsAfterACommit) {
  rig_.join();
  Commit many;
  many.revision = rig_.server.scene.revision() + 1;
  many.prevRoot = rig_.server.scene.root();
  for (ObjectId id = 100; id < 100 + kMaxHeldObjects; ++id) {
    many.put.push_back(object(id));
    many.put.back().revision = many.revision;
  }
  many.root = rig_.server.scene.apply(many)->root();
  v1::Commit message;
  toWire(many, message);
  rig_.server.sendCommit(message);
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_THAT(rig_.view().linkText, HasSubstr("more than 1024 objects"));
  EXPECT_EQ(rig_.view().scene->objects().size(), 2U) << "as it was";
}

TEST_F(SessionLimits, OfAssetsThatAreAnnounced) {
  rig_.server.addObject("c");
  rig_.connect();
  rig_.server.welcome(false);
  rig_.server.snapshot();
  rig_.settle();
  for (const v1::Envelope& request : rig_.server.heard(v1::Envelope::kAssetRequest)) {
    v1::Envelope envelope;
    v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
    chunk.set_hash(request.asset_request().hash());
    chunk.set_kind(v1::ASSET_KIND_MESH);
    chunk.set_total_size(kMaxHeldAssets_bytes / 3 + 1);
    chunk.set_data("HMSH");
    rig_.server.send(envelope);
  }
  expectLeft("more than 640 MiB");
}

TEST_F(SessionLimits, CountsTheAssetsThatItHolds) {
  rig_.join();
  const std::size_t held_bytes = rig_.view().assetBytes;
  EXPECT_EQ(held_bytes, 2 * (4 * sizeof(Vec3f) + 4 * sizeof(TriangleIndices)));
  rig_.server.sendCommit(rig_.server.addObject("c"));
  rig_.settle();
  v1::Envelope envelope;
  v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
  chunk.set_hash(rig_.server.heard(v1::Envelope::kAssetRequest).back().asset_request().hash());
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(kMaxHeldAssets_bytes - held_bytes + 1);
  chunk.set_data("HMSH");
  rig_.server.send(envelope);
  expectLeft("more than 640 MiB");
}

TEST_F(SessionLimits, OfWhatTheServerSaysOfItself) {
  welcome([](v1::Welcome& welcome) { welcome.set_server_name(std::string(kMaxServerText_bytes + 1, 'x')); });
  expectLeft("welcome.server_name: is longer than 1000 bytes");
}

TEST_F(SessionLimits, OfTheDevicesName) {
  welcome([](v1::Welcome& welcome) { welcome.set_device(std::string(kMaxServerText_bytes + 1, 'x')); });
  expectLeft("welcome.device: is longer than 1000 bytes");
}

TEST_F(SessionLimits, ARefusalsTextIsCut) {
  rig_.connect();
  v1::Envelope envelope;
  envelope.mutable_refusal()->set_reason(std::string(100'000, 'x'));
  rig_.server.send(envelope);
  rig_.settle();
  EXPECT_EQ(rig_.view().link, LinkState::kRefused);
  EXPECT_LT(rig_.view().linkText.size(), kMaxServerText_bytes + 100);
}

/// A connection to a server that reads nothing.
class Unread : public Transport {
 public:
  void start(Events /*events*/) override {}
  void send(std::string bytes) override { backlog_ += bytes.size(); }
  [[nodiscard]] std::size_t backlog() const noexcept override { return backlog_; }
  void close(const std::string& /*why*/) override {}
  [[nodiscard]] std::string peer() const override { return "deaf"; }

 private:
  std::size_t backlog_ = 0;
};

TEST_F(SessionLimits, OfWhatWaitsForAServerThatDoesNotRead) {
  Unread transport;
  rig_.client.connected(transport, rig_.now_ns);
  rig_.client.poll(rig_.now_ns);
  EXPECT_FALSE(rig_.client.connectionOver());
  transport.send(std::string(kMaxUnsent_bytes, 'x'));
  rig_.client.poll(rig_.now_ns);
  EXPECT_TRUE(rig_.client.connectionOver());
  EXPECT_THAT(rig_.client.overReason(), HasSubstr("does not read: 64 MiB"));
  rig_.client.connectionLost(rig_.client.overReason());
}

}  // namespace
}  // namespace haptics::session_limits_test
