#include <gmock/gmock.h>

#include <functional>

#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"
#include "tests/graphics_client/mirror/session_join_fixture.h"

// Copies that differ, refusals, and servers that talk nonsense.
namespace haptics::session_out_of_step_test {
namespace {

using testing::HasSubstr;

// ---- Out of step ----

class OutOfStep : public SessionJoin {
 protected:
  void SetUp() override {
    SessionJoin::SetUp();
    rig_.join();
    next_ = rig_.server.addObject("c");
  }

  /// The session leaves, claims nothing next time, and is in step again after the snapshot.
  void expectResync() {
    rig_.settle();
    EXPECT_EQ(rig_.connectionsEnded, 1);
    EXPECT_EQ(rig_.view().resyncs, 1U);
    EXPECT_THAT(rig_.view().linkText, HasSubstr("out of step"));
    rig_.join();
    EXPECT_EQ(hello().epoch(), 0U);
    EXPECT_TRUE(hello().root().empty());
    expectInStep();
    EXPECT_EQ(rig_.view().stateResets, 0U);
    rig_.cut();
    rig_.connect();
    EXPECT_EQ(hello().epoch(), rig_.server.epoch);  // trusts itself again
  }

  static std::string flipped(std::string bytes) {
    bytes[0] = static_cast<char>(bytes[0] ^ 1);
    return bytes;
  }

  v1::Commit next_;
};

TEST_F(OutOfStep, WhenACommitStartsFromAnotherRoot) {
  next_.set_prev_root(flipped(next_.prev_root()));
  rig_.server.sendCommit(next_);
  expectResync();
}

TEST_F(OutOfStep, WhenACommitLeadsToAnotherRoot) {
  next_.set_root(flipped(next_.root()));
  rig_.server.sendCommit(next_);
  expectResync();
}

TEST_F(OutOfStep, WhenACommitWasMissed) {
  rig_.server.sendCommit(rig_.server.addObject("d"));
  expectResync();
}

TEST_F(OutOfStep, WhenACommitCannotBeRead) {
  next_.mutable_put(0)->set_stiffness_n_per_m(-1);
  rig_.server.sendCommit(next_);
  expectResync();
}

TEST_F(OutOfStep, WhenAHeartbeatHasAnotherRootAtTheSameRevision) {
  v1::Envelope envelope;
  envelope.mutable_heartbeat()->set_epoch(rig_.server.epoch);
  envelope.mutable_heartbeat()->set_revision(2);
  envelope.mutable_heartbeat()->set_root(rig_.server.scene.root().asBytes());
  rig_.server.send(envelope);
  expectResync();
}

TEST_F(OutOfStep, WhenItsOwnMemoryIsNoLongerWhatItWas) {
  rig_.server.sendCommit(next_);
  rig_.settle();
  const auto object = rig_.client.mirror().scene().objects()[0];
  const_cast<ObjectRecord&>(*object).material.color.red += 0.125F;
  rig_.server.heartbeat();
  rig_.settle();
  expectResync();
}

TEST_F(OutOfStep, WhenAMeshInItsMemoryIsNoLongerWhatItWas) {
  rig_.server.sendCommit(next_);
  rig_.settle();
  const auto mesh = rig_.client.mirror().contents().meshes.begin()->second;
  const_cast<TriMesh&>(*mesh).vertices[0].x += 0.125F;
  for (std::size_t i = 0; i < rig_.client.mirror().contents().meshes.size() && rig_.view().resyncs == 0; ++i) {
    rig_.server.heartbeat();
    rig_.settle();
  }
  expectResync();
}

TEST_F(OutOfStep, WhenTwoHeartbeatsInARowAreAheadWithoutACommit) {
  rig_.server.heartbeat();
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 0);
  EXPECT_FALSE(rig_.view().hashesEqual);
  rig_.server.heartbeat();
  expectResync();
}

TEST_F(OutOfStep, ButNotWhenTheCommitFollowsTheHeartbeat) {
  rig_.server.heartbeat();
  rig_.server.sendCommit(next_);
  rig_.server.addObject("d");
  rig_.server.heartbeat();
  rig_.settle();
  EXPECT_EQ(rig_.view().resyncs, 0U);
}

TEST_F(OutOfStep, WhenAMeshDoesNotHashToItsName) {
  rig_.server.sendCommit(next_);
  const ContentHash hash = *ContentHash::fromBytes(next_.put(0).mesh());
  const std::string good = rig_.server.assets.at(hash);
  rig_.server.assets[hash] = encodeMesh(tetrahedron(99));
  rig_.server.asset(hash);
  rig_.settle();
  rig_.server.assets[hash] = good;
  expectResync();
}

TEST_F(OutOfStep, WhenAnAssetChangesItsSizeAndTheAssetIsTakenAnew) {
  rig_.server.sendCommit(next_);
  rig_.settle();
  const std::string hash = rig_.server.heard(v1::Envelope::kAssetRequest).back().asset_request().hash();
  v1::Envelope envelope;
  v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
  chunk.set_hash(hash);
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(7);
  chunk.set_data("wrong");
  rig_.server.send(envelope);
  chunk.set_offset(chunk.data().size());
  chunk.set_total_size(8);
  rig_.server.send(envelope);
  expectResync();
}

TEST_F(OutOfStep, TakesAnAssetAnewOfWhichItHasMoreThanThereIs) {
  rig_.server.sendCommit(next_);
  rig_.settle();
  v1::Envelope envelope;
  v1::AssetChunk& chunk = *envelope.mutable_asset_chunk();
  chunk.set_hash(rig_.server.heard(v1::Envelope::kAssetRequest).back().asset_request().hash());
  chunk.set_kind(v1::ASSET_KIND_MESH);
  chunk.set_total_size(2000);
  chunk.set_data(std::string(1000, 'x'));
  rig_.server.send(envelope);
  rig_.settle();
  rig_.cut();
  rig_.join();
  ASSERT_EQ(rig_.server.heard(v1::Envelope::kAssetRequest).back().asset_request().offset(), 1000U);
  envelope.mutable_refusal()->set_field("asset_request.offset");
  rig_.server.send(envelope);
  rig_.settle();
  rig_.join();
  expectInStep();
}

TEST_F(OutOfStep, WhenASnapshotHasAnotherRoot) {
  rig_.cut();
  rig_.connectionsEnded = 0;
  rig_.connect();
  rig_.server.welcome(false);
  v1::Envelope begin;
  begin.mutable_snapshot_begin()->set_revision(rig_.server.scene.revision());
  rig_.server.send(begin);
  v1::Envelope end;
  end.mutable_snapshot_end()->set_revision(rig_.server.scene.revision());
  end.mutable_snapshot_end()->set_root(rig_.server.scene.root().asBytes());
  rig_.server.send(end);
  expectResync();
}

TEST_F(OutOfStep, WhenASnapshotHasMoreObjectsThanSaid) {
  rig_.cut();
  rig_.connectionsEnded = 0;
  rig_.connect();
  rig_.server.welcome(false);
  v1::Envelope begin;
  begin.mutable_snapshot_begin()->set_object_count(0);
  rig_.server.send(begin);
  v1::Envelope objects;
  toWire(*rig_.server.scene.find(1), *objects.mutable_snapshot_objects()->add_object());
  rig_.server.send(objects);
  expectResync();
}

// ---- Refusals and nonsense ----

v1::Envelope refusal() {
  v1::Envelope envelope;
  envelope.mutable_refusal()->set_field("token");
  envelope.mutable_refusal()->set_reason("is not known");
  return envelope;
}

TEST_F(SessionJoin, ShowsARefusalAndWaitsLongerBeforeItTriesAgain) {
  rig_.connect();
  rig_.server.send(refusal());
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_EQ(rig_.view().link, LinkState::kRefused);
  EXPECT_EQ(rig_.view().linkText, "refused by the server: token: is not known");
  EXPECT_EQ(rig_.client.reconnectDelay_ns(), ClientSession::kRefusedDelay_ns);
  rig_.connect();
  EXPECT_EQ(rig_.view().link, LinkState::kRefused);  // until it is welcome
  rig_.server.welcome(false);
  rig_.settle();
  EXPECT_EQ(rig_.view().link, LinkState::kSyncing);
  EXPECT_LE(rig_.client.reconnectDelay_ns(), ClientSession::kMaxReconnectDelay_ns);
}

TEST_F(SessionJoin, ComesBackSoonWhenTheServerEndsAConnectionThatItWelcomed) {
  rig_.join();
  rig_.server.send(refusal());
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_EQ(rig_.view().link, LinkState::kConnecting);
  EXPECT_EQ(rig_.view().linkText, "the server ended the connection: token: is not known");
  EXPECT_LE(rig_.client.reconnectDelay_ns(), ClientSession::kMaxReconnectDelay_ns);
}

TEST_F(SessionJoin, TakesAnotherProtocolVersionForARefusal) {
  rig_.connect();
  v1::Envelope envelope;
  envelope.set_protocol_version(2);
  envelope.mutable_welcome()->set_epoch(1);
  std::string frame;
  (void)appendFrame(frame, envelope);
  rig_.server.sendBytes(frame);
  rig_.settle();
  EXPECT_EQ(rig_.view().link, LinkState::kRefused);
  EXPECT_THAT(rig_.view().linkText, HasSubstr("speaks version 2, this client version 1"));
}

TEST_F(SessionJoin, LeavesAServerThatDoesNotSpeakTheProtocol) {
  rig_.connect();
  rig_.server.sendBytes("HTTP/1.1 400 Bad Request\r\n\r\n");
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_THAT(rig_.view().linkText, HasSubstr("does not speak this protocol"));
}

TEST_F(SessionJoin, SaysWhyTheLastConnectionEndedUntilOneIsLive) {
  rig_.connect();
  rig_.server.heartbeat();
  rig_.settle();
  rig_.connect();
  EXPECT_THAT(rig_.view().linkText, HasSubstr("awaiting its welcome; before: the server sent something before"));
  rig_.server.welcome(false);
  rig_.settle();
  EXPECT_THAT(rig_.view().linkText, HasSubstr("getting the scene from"));
  EXPECT_THAT(rig_.view().linkText, HasSubstr("; before: the server sent something before"));
  rig_.server.snapshot();
  rig_.settle();
  rig_.cut();
  rig_.connect();
  EXPECT_THAT(rig_.view().linkText, testing::EndsWith("before: cut"));
}

TEST_F(SessionJoin, LeavesAServerThatSpeaksOutOfTurn) {
  const std::vector<std::function<void(FakeServer&)>> turns = {
      [](FakeServer& s) { s.heartbeat(); },                                     // before its welcome
      [](FakeServer& s) { s.welcome(true), s.heartbeat(); },                    // resumes what the client lacks
      [](FakeServer& s) { s.welcome(false), s.welcome(false); },                // twice
      [](FakeServer& s) { s.welcome(false), s.sendCommit(s.addObject("x")); },  // commit before the snapshot
      [](FakeServer& s) {
        s.welcome(false);
        v1::Envelope end;
        end.mutable_snapshot_end()->set_revision(1);
        s.send(end);
      },
      [](FakeServer& s) {
        s.welcome(false);
        v1::Envelope objects;
        objects.mutable_snapshot_objects();
        s.send(objects);
      },
      [](FakeServer& s) {
        s.welcome(false);
        v1::Envelope envelope;
        envelope.mutable_subscribe();  // a client's message
        s.send(envelope);
      },
  };
  for (std::size_t i = 0; i < turns.size(); ++i) {
    SessionRig rig;
    rig.server.addObject("a");
    rig.connect();
    turns[i](rig.server);
    rig.settle();
    EXPECT_EQ(rig.connectionsEnded, 1) << i;
    rig.server.restart();
    rig.join();
    EXPECT_EQ(rig.view().link, LinkState::kLive) << i;
  }
}

TEST(ReconnectDelay, IsSpreadOverItsRange) {
  ClientSession session({.session = 5, .clientName = "", .token = "", .telemetryRate_Hz = 0, .fetchAssets = true});
  std::uint64_t least = ~0ULL;
  std::uint64_t most = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t delay_ns = session.reconnectDelay_ns();
    least = std::min(least, delay_ns);
    most = std::max(most, delay_ns);
  }
  EXPECT_GE(least, ClientSession::kMinReconnectDelay_ns);
  EXPECT_LE(most, ClientSession::kMaxReconnectDelay_ns);
  EXPECT_GT(most - least, 400'000'000U);
}

}  // namespace
}  // namespace haptics::session_out_of_step_test
