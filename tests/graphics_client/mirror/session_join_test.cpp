#include <gmock/gmock.h>

#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"
#include "tests/graphics_client/mirror/fake_server.h"

// Joining, resuming, being out of step, and losing the connection at every moment of it.
namespace haptics {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

class SessionJoin : public testing::Test {
 protected:
  void SetUp() override {
    rig_.server.addObject("a");
    rig_.server.addObject("b");
  }

  v1::Hello hello() const { return rig_.server.heard(v1::Envelope::kHello).at(0).hello(); }

  void expectInStep() {
    const MirrorView view = rig_.view();
    EXPECT_EQ(view.link, LinkState::kLive);
    EXPECT_TRUE(view.hashesEqual);
    EXPECT_EQ(view.scene->root(), rig_.server.scene.root());
    EXPECT_EQ(*recomputedRoot(view), rig_.server.scene.root());
  }

  SessionRig rig_;
};

TEST_F(SessionJoin, SaysHelloFirstAndClaimsNothing) {
  rig_.connect();
  ASSERT_EQ(rig_.server.heard().size(), 1U);
  EXPECT_EQ(hello().session(), 77U);
  EXPECT_EQ(hello().client_name(), "test");
  EXPECT_EQ(hello().epoch(), 0U);
  EXPECT_EQ(rig_.view().link, LinkState::kConnecting);
}

TEST_F(SessionJoin, GetsTheSnapshotThenTheMeshes) {
  rig_.join();
  expectInStep();
  const MirrorView view = rig_.view();
  EXPECT_EQ(view.serverName, "fake");
  EXPECT_EQ(view.device, "simulated");
  EXPECT_EQ(view.maxForce_N, 5);
  EXPECT_EQ(view.servoRate_Hz, 1000);
  EXPECT_TRUE(view.mayEdit);
  EXPECT_EQ(view.connections, 1U);
  EXPECT_EQ(view.resyncs, 0U);
  EXPECT_EQ(view.stateResets, 0U);
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kAssetRequest).size(), 2U);
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kSubscribe).at(0).subscribe().rate_hz(), 60);
}

TEST_F(SessionJoin, JoinsWhateverThePiecesInWhichTheBytesArrive) {
  for (const std::size_t piece : {1, 7, 100, 5'000}) {
    SessionRig rig;
    rig.server.addObject("a");
    rig.connect();
    rig.server.welcome(false);
    rig.server.snapshot();
    while (rig.link->pump(piece)) {
    }
    rig.server.asset(rig.server.scene.objects()[0]->mesh);
    while (rig.link->pump(piece)) {
    }
    EXPECT_TRUE(rig.view().hashesEqual) << piece;
  }
}

TEST_F(SessionJoin, IsNotEqualBeforeTheLastMeshIsThere) {
  rig_.connect();
  rig_.server.welcome(false);
  rig_.server.snapshot();
  rig_.server.asset(rig_.server.scene.objects()[0]->mesh);
  rig_.settle();
  EXPECT_EQ(rig_.view().link, LinkState::kLive);
  EXPECT_FALSE(rig_.view().hashesEqual);
  rig_.server.asset(rig_.server.scene.objects()[1]->mesh);
  rig_.settle();
  expectInStep();
}

TEST_F(SessionJoin, AsksForNoMeshesWhenItWantsNone) {
  SessionRig rig({.session = 1, .clientName = "", .token = "", .telemetryRate_Hz = 0, .fetchMeshes = false});
  rig.server.addObject("a");
  rig.join();
  EXPECT_TRUE(rig.server.heard(v1::Envelope::kAssetRequest).empty());
  EXPECT_TRUE(rig.server.heard(v1::Envelope::kSubscribe).empty());
  EXPECT_EQ(rig.view().link, LinkState::kLive);
  EXPECT_EQ(rig.view().scene->root(), rig.server.scene.root());
}

TEST_F(SessionJoin, FollowsCommits) {
  rig_.join();
  for (int i = 0; i < 10; ++i) {
    ObjectRecord record = *rig_.server.scene.find(1);
    record.pose.position.x = 0.1 * i;
    rig_.server.sendCommit(rig_.server.change(record));
    rig_.settle();
    expectInStep();
  }
  EXPECT_EQ(rig_.view().scene->revision(), 12U);
  EXPECT_EQ(rig_.view().scene->find(1)->pose.position.x, 0.1 * 9);
}

TEST_F(SessionJoin, FetchesTheMeshOfACommit) {
  rig_.join();
  rig_.server.sendCommit(rig_.server.addObject("c"));
  rig_.settle();
  EXPECT_FALSE(rig_.view().hashesEqual);
  const auto requests = rig_.server.heard(v1::Envelope::kAssetRequest);
  ASSERT_EQ(requests.size(), 3U);
  rig_.server.asset(*ContentHash::fromBytes(requests[2].asset_request().hash()));
  rig_.settle();
  expectInStep();
}

TEST_F(SessionJoin, ResumesFromWhatItHoldsByTheCommitsThatItMissed) {
  rig_.join();
  const ContentHash held = rig_.server.scene.root();
  rig_.cut();
  EXPECT_EQ(rig_.view().link, LinkState::kConnecting);
  EXPECT_EQ(rig_.view().scene->root(), held);  // still shown
  ObjectRecord record = *rig_.server.scene.find(2);
  record.material.stiffness_N_per_m = 123;
  const v1::Commit first = rig_.server.change(record);
  record.material.stiffness_N_per_m = 456;
  const v1::Commit second = rig_.server.change(record);

  rig_.connect();
  EXPECT_EQ(hello().session(), 77U);
  EXPECT_EQ(hello().epoch(), rig_.server.epoch);
  EXPECT_EQ(hello().revision(), 2U);
  EXPECT_EQ(hello().root(), held.asBytes());
  rig_.server.welcome(true);
  rig_.settle();
  EXPECT_EQ(rig_.view().link, LinkState::kSyncing);
  rig_.server.sendCommit(first);
  rig_.server.sendCommit(second);
  rig_.settle();
  expectInStep();
  EXPECT_EQ(rig_.view().connections, 2U);
  EXPECT_EQ(rig_.view().resyncs, 0U);
  EXPECT_TRUE(rig_.server.heard(v1::Envelope::kAssetRequest).empty());
}

TEST_F(SessionJoin, IsLiveAtOnceWhenItMissedNothing) {
  rig_.join();
  rig_.cut();
  rig_.connect();
  rig_.server.welcome(true);
  rig_.settle();
  expectInStep();
}

TEST_F(SessionJoin, TakesASnapshotWhereTheServerCannotResume) {
  rig_.join();
  rig_.cut();
  rig_.server.addObject("c");
  rig_.join();
  expectInStep();
  EXPECT_EQ(rig_.view().resyncs, 0U);
  EXPECT_EQ(rig_.view().stateResets, 0U);
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kAssetRequest).size(), 1U);  // only what it lacks
}

TEST_F(SessionJoin, ShowsAStateResetWhenTheServerRestarted) {
  rig_.join();
  rig_.server.telemetry(1'000'000);
  rig_.settle();
  rig_.cut();
  rig_.server.restart();
  rig_.server.addObject("fresh");
  rig_.join();
  expectInStep();
  EXPECT_EQ(rig_.view().stateResets, 1U);
  EXPECT_EQ(rig_.view().resyncs, 0U);
  EXPECT_FALSE(rig_.view().sample);
  rig_.server.telemetry(1);  // its ticks start anew
  rig_.settle();
  EXPECT_EQ(rig_.view().sample->tick, 1U);
}

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

// ---- Connections that end early ----

TEST_F(SessionJoin, StartsOverWhenTheConnectionIsLostAnywhereInTheSnapshot) {
  // As many bytes as welcome and snapshot have; cut after each of them.
  for (std::size_t cut = 0;; ++cut) {
    SessionRig rig;
    rig.server.addObject("a");
    rig.server.addObject("b");
    rig.connect();
    rig.server.welcome(false);
    rig.server.snapshot();
    if (cut > 0) rig.link->pump(cut);
    const bool whole = rig.view().scene->revision() != 0;
    rig.cut();
    EXPECT_EQ(rig.connectionsEnded, 1);
    rig.join();
    ASSERT_EQ(rig.server.heard(v1::Envelope::kHello).at(0).hello().epoch(), whole ? rig.server.epoch : 0U) << cut;
    ASSERT_TRUE(rig.view().hashesEqual) << cut;
    ASSERT_EQ(rig.view().resyncs, 0U) << cut;
    if (whole) break;
    ASSERT_LT(cut, 10'000U);
  }
}

TEST_F(SessionJoin, KeepsTheOldSceneInViewUntilTheNewSnapshotIsWhole) {
  rig_.join();
  const ContentHash old = rig_.view().scene->root();
  rig_.cut();
  rig_.server.addObject("c");
  rig_.connect();
  rig_.server.welcome(false);
  rig_.settle();
  EXPECT_EQ(rig_.view().scene->root(), old);
  EXPECT_FALSE(rig_.view().hashesEqual);
  rig_.cut();
  rig_.connect();
  EXPECT_EQ(hello().epoch(), 0U);  // the server could not resume before, it is asked for a snapshot
}

TEST_F(SessionJoin, GoesOnWithAMeshWhereTheConnectionWasLost) {
  ObjectRecord record = *rig_.server.scene.find(1);
  record.mesh = rig_.server.addMesh(grid(40));
  rig_.server.change(record);
  const ContentHash large = record.mesh;
  const std::size_t size = rig_.server.assets.at(large).size();
  rig_.connect();
  rig_.server.welcome(false);
  rig_.server.snapshot();
  rig_.server.chunk(large, 0, 10'000);
  rig_.server.chunk(large, 10'000, 5'000);
  rig_.settle();
  rig_.cut();

  rig_.connect();
  rig_.server.welcome(true);
  rig_.settle();
  std::map<std::string, std::uint64_t> offsets;
  for (const auto& request : rig_.server.heard(v1::Envelope::kAssetRequest)) {
    offsets[request.asset_request().hash()] = request.asset_request().offset();
  }
  ASSERT_EQ(offsets.size(), 2U);
  EXPECT_EQ(offsets.at(large.asBytes()), 15'000U);
  ASSERT_GT(size, 15'000U);
  rig_.server.asset(large, 15'000);
  rig_.server.asset(rig_.server.scene.find(2)->mesh);
  rig_.settle();
  expectInStep();
}

TEST_F(SessionJoin, KeepsTryingForAMeshThatTheServerDoesNotHoldYet) {
  rig_.connect();
  rig_.server.welcome(false);
  rig_.server.snapshot();
  rig_.settle();
  v1::Envelope unavailable;
  unavailable.mutable_asset_unavailable()->set_hash(rig_.server.scene.find(1)->mesh.asBytes());
  rig_.server.send(unavailable);
  rig_.settle();
  const std::size_t asked = rig_.server.heard(v1::Envelope::kAssetRequest).size();
  rig_.advance(2 * kSecond_ns);
  EXPECT_GT(rig_.server.heard(v1::Envelope::kAssetRequest).size(), asked);
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
  EXPECT_LE(rig_.client.reconnectDelay_ns(), ClientSession::kMostReconnectDelay_ns);
}

TEST_F(SessionJoin, ComesBackSoonWhenTheServerEndsAConnectionThatItWelcomed) {
  rig_.join();
  rig_.server.send(refusal());
  rig_.settle();
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_EQ(rig_.view().link, LinkState::kConnecting);
  EXPECT_EQ(rig_.view().linkText, "the server ended the connection: token: is not known");
  EXPECT_LE(rig_.client.reconnectDelay_ns(), ClientSession::kMostReconnectDelay_ns);
}

TEST_F(SessionJoin, TakesAnotherProtocolVersionForARefusal) {
  rig_.connect();
  v1::Envelope envelope;
  envelope.set_protocol_version(2);
  envelope.mutable_welcome()->set_epoch(1);
  std::string frame;
  appendFrame(frame, envelope);
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
  ClientSession session({.session = 5, .clientName = "", .token = "", .telemetryRate_Hz = 0, .fetchMeshes = true});
  std::uint64_t least = ~0ULL;
  std::uint64_t most = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t delay_ns = session.reconnectDelay_ns();
    least = std::min(least, delay_ns);
    most = std::max(most, delay_ns);
  }
  EXPECT_GE(least, ClientSession::kLeastReconnectDelay_ns);
  EXPECT_LE(most, ClientSession::kMostReconnectDelay_ns);
  EXPECT_GT(most - least, 400'000'000U);
}

}  // namespace
}  // namespace haptics
