#include "graphics_client/mirror/mirror.h"

#include <gmock/gmock.h>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/scene_text.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics::mirror_test {
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
    for (const auto& [hash, bytes] : server_.assets) ASSERT_TRUE(mirror_.addAsset({AssetKind::kMesh, hash}, bytes));
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
  ASSERT_EQ(mirror_.lackingAssets().size(), 1U);
  EXPECT_FALSE(mirror_.contents().hashesEqual);
  EXPECT_FALSE(recomputedRoot(mirror_.contents()));
  const AssetName lacking = mirror_.lackingAssets()[0];
  ASSERT_TRUE(mirror_.addAsset(lacking, server_.assets.at(lacking.hash)));
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
  const auto added = mirror_.addAsset({AssetKind::kMesh, wrong}, encodeMesh(tetrahedron(124)));
  ASSERT_FALSE(added);
  EXPECT_THAT(added.error().text(), HasSubstr(wrong.hex()));
}

TEST_F(MirrorOfTwo, RefusesBytesThatAreNoMesh) {
  EXPECT_FALSE(mirror_.addAsset({AssetKind::kMesh, hashOf(tetrahedron(1))}, "rubbish"));
  EXPECT_FALSE(mirror_.addAsset({AssetKind::kMesh, hashOf(tetrahedron(1))}, encodeMesh(tetrahedron(1)).substr(1)));
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
  ASSERT_TRUE(mirror_.addAsset({AssetKind::kMesh, hashOf(mesh)}, encodeMesh(mesh)));
  EXPECT_EQ(mirror_.contents().meshes.size(), 2U);
}

TEST_F(MirrorOfTwo, ListsAMeshThatTwoObjectsShareOnce) {
  ObjectRecord record = *server_.scene.find(1);
  record.mesh = server_.addMesh(tetrahedron(70));
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  record.id = 9;
  record.name = "twin";
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.lackingAssets(), (std::vector<AssetName>{{AssetKind::kMesh, record.mesh}}));
}

/// The scene's first object with a mapped texture and friction per vertex.
class MirrorOfSurfaces : public MirrorOfTwo {
 protected:
  MirrorOfSurfaces() : field_(SampledField::make(2, 2, {0, 0.25F, 0.5F, 1}).value()) {}
  void SetUp() override {
    MirrorOfTwo::SetUp();
    ObjectRecord record = *server_.scene.find(1);
    SurfaceProperties& surface = record.material.surface;
    surface.texture = Texture{.family = MappedFamily{hashOf(field_), {.tile_m = 0.01}}, .amplitude_m = 1e-3};
    surface.friction = Friction{1, 1, 0, PerVertexScale{hashOf(values_)}};
    ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
    mirror_.announce(server_.scene.revision(), server_.scene.root());
  }
  void bringAssets() {
    ASSERT_TRUE(mirror_.addAsset(fieldName(), encodeField(field_)));
    ASSERT_TRUE(mirror_.addAsset(valuesName(), encodeVertexValues(values_)));
  }
  [[nodiscard]] AssetName fieldName() const { return {AssetKind::kScalarField, hashOf(field_)}; }
  [[nodiscard]] AssetName valuesName() const { return {AssetKind::kVertexValues, hashOf(values_)}; }

  const SampledField field_;
  const std::vector<float> values_{1, 0.5F, 0.25F, 0};
};

TEST_F(MirrorOfSurfaces, LacksTheirAssetsUntilTheyAreHere) {
  EXPECT_THAT(mirror_.lackingAssets(), testing::ElementsAre(valuesName(), fieldName()));
  EXPECT_FALSE(mirror_.contents().hashesEqual);
  EXPECT_FALSE(mirror_.contents().isComplete(*server_.scene.find(1)));
  EXPECT_TRUE(mirror_.contents().isComplete(*server_.scene.find(2)));
  EXPECT_THAT(recomputedRoot(mirror_.contents()).error().text(), HasSubstr("surface has not arrived"));
  bringAssets();
  EXPECT_TRUE(mirror_.contents().hashesEqual);
  EXPECT_EQ(*recomputedRoot(mirror_.contents()), server_.scene.root());
}

TEST_F(MirrorOfSurfaces, RefuseAnAssetOfAnotherKindOrContent) {
  EXPECT_FALSE(mirror_.addAsset(fieldName(), encodeVertexValues(values_)));
  EXPECT_FALSE(mirror_.addAsset({AssetKind::kScalarField, hashOf(values_)}, encodeVertexValues(values_)));
  EXPECT_FALSE(mirror_.addAsset(valuesName(), encodeVertexValues(std::vector<float>{1, 2})));
  EXPECT_EQ(mirror_.lackingAssets().size(), 2U);
}

TEST_F(MirrorOfSurfaces, FindWhatChangedInMemoryAndLetGoOfIt) {
  bringAssets();
  EXPECT_TRUE(mirror_.audit(1U << 20));
  const_cast<std::vector<float>&>(*mirror_.contents().vertexValues.at(hashOf(values_)))[2] = 7;
  EXPECT_NE(*recomputedRoot(mirror_.contents()), server_.scene.root());
  EXPECT_FALSE(mirror_.audit(1U << 20));
  EXPECT_THAT(mirror_.lackingAssets(), testing::ElementsAre(valuesName()));
}

TEST_F(MirrorOfSurfaces, LetGoOfAssetsThatTheSceneNoLongerNames) {
  bringAssets();
  ObjectRecord record = *server_.scene.find(1);
  record.material.surface.texture.reset();
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_TRUE(mirror_.contents().fields.empty());
  EXPECT_EQ(mirror_.contents().vertexValues.size(), 1U);
}

TEST_F(MirrorOfTwo, HoldsWhatIsGrownByItsHash) {
  const PointField points = PointField::make(1, {{{0, 0, 0}, 1}, {{0.5F, 0, 0}, -1}}).value();
  const AssetName name{AssetKind::kPointField, hashOf(points)};
  ObjectRecord record = *server_.scene.find(1);
  record.material.surface.texture = Texture{.family = GrownFamily{name.hash}, .amplitude_m = 1e-3};
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  mirror_.announce(server_.scene.revision(), server_.scene.root());
  EXPECT_EQ(mirror_.lackingAssets(), std::vector{name});
  EXPECT_FALSE(mirror_.contents().hashesEqual);
  EXPECT_FALSE(recomputedRoot(mirror_.contents()));
  const PointField other = PointField::make(1, {{{0, 0, 0}, 2}}).value();
  EXPECT_FALSE(mirror_.addAsset(name, encodePointField(other)));
  const std::size_t before = mirror_.contents().assetBytes;
  ASSERT_TRUE(mirror_.addAsset(name, encodePointField(points)));
  EXPECT_EQ(mirror_.contents().assetBytes, before + 2 * sizeof(PointSample));
  EXPECT_TRUE(mirror_.contents().hashesEqual);
  EXPECT_EQ(recomputedRoot(mirror_.contents()).value(), server_.scene.root());
  const_cast<PointSample&>(mirror_.contents().pointFields.at(name.hash)->samples()[1]).value = 0.5F;
  EXPECT_NE(recomputedRoot(mirror_.contents()).value(), server_.scene.root());
  bool found = false;
  for (int i = 0; i < 5; ++i) found = found || !mirror_.audit(1);
  EXPECT_TRUE(found) << "memory that changed";
  EXPECT_EQ(mirror_.lackingAssets(), std::vector{name});
  record = *server_.scene.find(1);
  record.material.surface.texture.reset();
  ASSERT_TRUE(mirror_.addAsset(name, encodePointField(points)));
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_TRUE(mirror_.contents().pointFields.empty());
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

TEST_F(MirrorOfTwo, KnowsWhereBodiesAreAndLetsThemGoWithTheirMotion) {
  ObjectRecord record = *server_.scene.find(1);
  record.motion = MotionProperties{.mass_kg = 1};
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.contents().poseOf(record), record.pose) << "before anything is known";
  const std::vector<BodyState> bodies{{1, Pose{Quat(1, 0, 0, 0), Vec3(1, 2, 3)}, BodyCondition::kAsleep},
                                      {2, Pose{}, BodyCondition::kAwake},
                                      {77, Pose{}, BodyCondition::kAwake}};
  ASSERT_TRUE(mirror_.take(sampleAt(5), bodies));
  EXPECT_EQ(mirror_.contents().bodies.size(), 1U) << "2 does not move, 77 is not there";
  EXPECT_EQ(mirror_.contents().poseOf(record).position, Vec3(1, 2, 3));
  ASSERT_TRUE(mirror_.take(sampleAt(6)));
  EXPECT_EQ(mirror_.contents().poseOf(record).position, Vec3(1, 2, 3)) << "left out: as it was";
  record = *server_.scene.find(1);
  record.motion.reset();
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.contents().poseOf(record), record.pose);
}

TEST_F(MirrorOfTwo, KnowsWhereAnObjectIsDrivenUntilAnEditHasSetItsPose) {
  const std::vector<BodyState> driven{{1, Pose{Quat(1, 0, 0, 0), Vec3(1, 2, 3)}, BodyCondition::kAwake}};
  ObjectRecord record = *server_.scene.find(1);
  TelemetrySample sample = sampleAt(5);
  sample.sceneRevision = server_.scene.revision();
  ASSERT_TRUE(mirror_.take(sample, driven));
  EXPECT_EQ(mirror_.contents().poseOf(record).position, Vec3(1, 2, 3));
  EXPECT_NE(textOf(additionsOf(mirror_.contents(), "")).find("z: 3"), std::string::npos) << "so it is saved";

  record.pose.position.x += 0.5;
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.contents().poseOf(record), record.pose);
  sample.tick = 6;
  ASSERT_TRUE(mirror_.take(sample, driven));
  EXPECT_EQ(mirror_.contents().poseOf(record), record.pose) << "the servo had not adopted the edit yet";
  sample.tick = 7;
  sample.sceneRevision = server_.scene.revision();
  ASSERT_TRUE(mirror_.take(sample, driven));
  EXPECT_EQ(mirror_.contents().poseOf(record).position, Vec3(1, 2, 3)) << "it is driven again, or still";
}

TEST_F(MirrorOfTwo, KnowsWhereASoftObjectsTrianglesAre) {
  ObjectRecord record = *server_.scene.find(1);
  const auto rest = mirror_.contents().cornersOf(record, 0).value();
  const ObjectDent dent{1, {Vec3f(rest[0]), Vec3f(0, 0, -0.25F)}};
  ASSERT_TRUE(mirror_.take(sampleAt(1), {}, {dent, {2, dent.dent}}));
  EXPECT_EQ(mirror_.contents().cornersOf(record, 0).value(), rest) << "it is rigid";
  record.deformation.softness = Softness{.stiffness_N_per_m = 1, .radius_m = 1e-3};
  EXPECT_EQ(mirror_.contents().dentsIn(record), std::vector{dent.dent});
  const auto dented = mirror_.contents().cornersOf(record, 0).value();
  EXPECT_EQ(dented[0], rest[0] + Vec3(0, 0, -0.25));
  EXPECT_EQ(dented[1], rest[1]);
  EXPECT_FALSE(mirror_.contents().cornersOf(record, 1'000'000));
  ASSERT_TRUE(mirror_.take(sampleAt(2)));
  EXPECT_EQ(mirror_.contents().cornersOf(record, 0).value(), rest) << "a sample without a dent: there is none";
}

TEST_F(MirrorOfTwo, HoldsAResidueByItsHashAndTellsTheShapeByIt) {
  ObjectRecord record = *server_.scene.find(1);
  const auto rest = mirror_.contents().cornersOf(record, 0).value();
  const auto vertex = mirror_.contents().meshes.at(record.mesh)->triangles[0][1];
  const MovedVertices moved{{vertex}, {Vec3f(0.5F)}};
  const AssetName name{AssetKind::kMovedVertices, hashOf(moved)};
  record.deformation.residue = name.hash;
  ASSERT_TRUE(mirror_.apply(decoded(server_.change(record))));
  EXPECT_EQ(mirror_.lackingAssets(), std::vector{name});
  EXPECT_FALSE(mirror_.contents().cornersOf(record, 0));
  EXPECT_FALSE(deformedHash(mirror_.contents()));
  EXPECT_FALSE(recomputedRoot(mirror_.contents()));
  EXPECT_FALSE(mirror_.addAsset(name, encodeMovedVertices({{vertex}, {Vec3f(0.25F)}}))) << "it is another";
  ASSERT_TRUE(mirror_.addAsset(name, encodeMovedVertices(moved)));
  const auto now = mirror_.contents().cornersOf(record, 0).value();
  EXPECT_EQ(now[1], Vec3(0.5));
  EXPECT_EQ(now[0], rest[0]);
  EXPECT_TRUE(deformedHash(mirror_.contents()));
  EXPECT_EQ(recomputedRoot(mirror_.contents()).value(), mirror_.scene().root());
  const_cast<MovedVertices&>(*mirror_.contents().movedVertices.at(name.hash)).place[0].x = 7;
  EXPECT_NE(recomputedRoot(mirror_.contents()).value(), mirror_.scene().root());
  bool found = false;
  for (int i = 0; i < 5; ++i) found = found || !mirror_.audit(1);
  EXPECT_TRUE(found) << "memory that changed";
}

TEST(MirrorTelemetry, StartsAnewWithAConnection) {
  Mirror mirror;
  mirror.take(sampleAt(1'000));
  mirror.startTelemetry();
  EXPECT_EQ(mirror.contents().sample->tick, 1'000U);  // still the newest known
  EXPECT_TRUE(mirror.take(sampleAt(1)));
}

}  // namespace
}  // namespace haptics::mirror_test
