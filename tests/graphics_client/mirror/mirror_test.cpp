#include "graphics_client/mirror/mirror.h"

#include <gmock/gmock.h>

#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics {
namespace {

using testing::HasSubstr;

TelemetrySample sampleAt(std::uint64_t tick) {
  TelemetrySample sample;
  sample.tick = tick;
  return sample;
}

/// A mirror of a fake server's scene of two objects, meshes included.
class MirrorOfTwo : public testing::Test {
 protected:
  void SetUp() override {
    server_.addObject("a");
    server_.addObject("b");
    ASSERT_TRUE(mirror_.replaceScene(server_.epoch, server_.scene, server_.scene.root()));
    mirror_.announce(server_.scene.revision(), server_.scene.root());
    for (const auto& [hash, bytes] : server_.assets) ASSERT_TRUE(mirror_.addMesh(hash, bytes));
  }

  static Commit decoded(const v1::Commit& message) { return *fromWire(message); }

  FakeServer server_;
  Mirror mirror_;
};

TEST(Mirror, HoldsAnEmptySceneAtFirst) {
  const Mirror mirror;
  EXPECT_TRUE(mirror.scene().objects().empty());
  EXPECT_EQ(mirror.epoch(), 0U);
  EXPECT_FALSE(mirror.contents().hashesEqual);
}

TEST_F(MirrorOfTwo, IsEqualWithTheServer) {
  EXPECT_TRUE(mirror_.contents().hashesEqual);
  EXPECT_EQ(mirror_.contents().meshes.size(), 2U);
  EXPECT_EQ(*recomputedRoot(mirror_.contents()), server_.scene.root());
}

TEST_F(MirrorOfTwo, IsNotEqualWhileTheServerIsAhead) {
  server_.addObject("c");
  mirror_.announce(server_.scene.revision(), server_.scene.root());
  EXPECT_FALSE(mirror_.contents().hashesEqual);
}

TEST_F(MirrorOfTwo, IsNotEqualWhileAMeshIsLacking) {
  ASSERT_TRUE(mirror_.apply(decoded(server_.addObject("c"))));
  mirror_.announce(server_.scene.revision(), server_.scene.root());
  ASSERT_EQ(mirror_.lackingMeshes().size(), 1U);
  EXPECT_FALSE(mirror_.contents().hashesEqual);
  EXPECT_FALSE(recomputedRoot(mirror_.contents()));
  const ContentHash lacking = mirror_.lackingMeshes()[0];
  ASSERT_TRUE(mirror_.addMesh(lacking, server_.assets.at(lacking)));
  EXPECT_TRUE(mirror_.contents().hashesEqual);
}

TEST_F(MirrorOfTwo, RefusesACommitThatStartsFromAnotherRoot) {
  Commit commit = decoded(server_.addObject("c"));
  commit.prevRoot.bytes[0] ^= 1;
  const auto applied = mirror_.apply(commit);
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().field, "prev_root");
  EXPECT_EQ(mirror_.scene().revision(), 2U);
}

TEST_F(MirrorOfTwo, RefusesACommitThatLeadsToAnotherRootAndKeepsWhatItHad) {
  Commit commit = decoded(server_.addObject("c"));
  commit.put[0].pose.position.x += 1e-15;
  const auto applied = mirror_.apply(commit);
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().field, "root");
  EXPECT_EQ(mirror_.scene().objects().size(), 2U);
}

TEST_F(MirrorOfTwo, RefusesASnapshotWithAnotherRoot) {
  ContentHash other = server_.scene.root();
  other.bytes[31] ^= 1;
  EXPECT_FALSE(mirror_.replaceScene(server_.epoch, server_.scene, other));
}

TEST_F(MirrorOfTwo, RefusesAMeshThatDoesNotHashToItsName) {
  server_.addObject("c");
  const ContentHash wrong = hashOf(tetrahedron(123));
  const auto added = mirror_.addMesh(wrong, encodeMesh(tetrahedron(124)));
  ASSERT_FALSE(added);
  EXPECT_THAT(added.error().text(), HasSubstr(wrong.hex()));
}

TEST_F(MirrorOfTwo, RefusesBytesThatAreNoMesh) {
  EXPECT_FALSE(mirror_.addMesh(hashOf(tetrahedron(1)), "rubbish"));
  EXPECT_FALSE(mirror_.addMesh(hashOf(tetrahedron(1)), encodeMesh(tetrahedron(1)).substr(1)));
}

TEST_F(MirrorOfTwo, LetsGoOfMeshesThatTheSceneNoLongerNames) {
  ObjectRecord record = *server_.scene.find(1);
  const ContentHash old = record.mesh;
  record.mesh = server_.addMesh(tetrahedron(50));
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_FALSE(mirror_.contents().meshes.contains(old));
  EXPECT_EQ(mirror_.contents().meshes.size(), 1U);
}

TEST_F(MirrorOfTwo, DoesNotKeepAMeshThatCameTooLate) {
  const TriMesh mesh = tetrahedron(60);
  ASSERT_TRUE(mirror_.addMesh(hashOf(mesh), encodeMesh(mesh)));
  EXPECT_EQ(mirror_.contents().meshes.size(), 2U);
}

TEST_F(MirrorOfTwo, ListsAMeshThatTwoObjectsShareOnce) {
  ObjectRecord record = *server_.scene.find(1);
  record.mesh = server_.addMesh(tetrahedron(70));
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  record.id = 9;
  record.name = "twin";
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.lackingMeshes(), std::vector<ContentHash>{record.mesh});
}

TEST_F(MirrorOfTwo, CountsAStateResetWhenTheEpochChanges) {
  mirror_.take(sampleAt(5));
  ASSERT_TRUE(mirror_.replaceScene(server_.epoch, server_.scene, server_.scene.root()));
  EXPECT_EQ(mirror_.contents().stateResets, 0U);
  ASSERT_TRUE(mirror_.replaceScene(server_.epoch + 1, SceneVersion(), SceneVersion().root()));
  EXPECT_EQ(mirror_.contents().stateResets, 1U);
  EXPECT_FALSE(mirror_.contents().sample);
}

TEST_F(MirrorOfTwo, SeesAFlippedBitInItsOwnMesh) {
  MirrorView view = mirror_.contents();
  TriMesh spoiled = *view.meshes.begin()->second;
  spoiled.vertices[1].x = std::nextafter(spoiled.vertices[1].x, 1e9F);
  view.meshes.begin()->second = std::make_shared<const TriMesh>(spoiled);
  EXPECT_NE(*recomputedRoot(view), server_.scene.root());
}

TEST(MirrorTelemetry, KeepsTheNewestAndDropsTheRest) {
  Mirror mirror;
  EXPECT_TRUE(mirror.take(sampleAt(0)));
  EXPECT_TRUE(mirror.take(sampleAt(10)));
  for (const std::uint64_t tick : {0, 9, 10}) EXPECT_FALSE(mirror.take(sampleAt(tick))) << tick;
  EXPECT_EQ(mirror.contents().sample->tick, 10U);
  EXPECT_EQ(mirror.contents().samplesReceived, 2U);
}

TEST(MirrorTelemetry, StartsAnewWithAConnection) {
  Mirror mirror;
  mirror.take(sampleAt(1'000));
  mirror.startTelemetry();
  EXPECT_EQ(mirror.contents().sample->tick, 1'000U);  // still the newest known
  EXPECT_TRUE(mirror.take(sampleAt(1)));
}

}  // namespace
}  // namespace haptics
