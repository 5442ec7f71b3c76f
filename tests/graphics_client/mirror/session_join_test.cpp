#include "tests/graphics_client/mirror/session_join_fixture.h"

// Joining, resuming, and losing the connection at every moment of it.
namespace haptics::session_join_test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

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
  SessionRig rig({.session = 1, .clientName = "", .token = "", .telemetryRate_Hz = 0, .fetchAssets = false});
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

}  // namespace
}  // namespace haptics::session_join_test
