#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "common/surface/field_asset.h"
#include "haptic_server/scene/sequencer.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics {
namespace {

using namespace test;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kBoxVertices = 8;

MappedFamily mapped(Vec3 centre = {}, Vec3 size = Vec3(1)) {
  return {{}, {Mapping::Shape::kSphere, centre, {1, 0, 0, 0}, size, 0.01}};
}

Operation setSurface(SurfaceEdit surface, std::string name = "a") {
  MaterialEdit material;
  material.surface = std::move(surface);
  return SetMaterial{named(std::move(name)), std::move(material)};
}

SurfaceEdit textured(std::uint32_t seed, MappedFamily family = mapped(), bool ofMesh = false) {
  SurfaceEdit edit;
  edit.texture = TextureEdit{Texture{.family = family, .amplitude_m = 1e-3},
                             MappedSource{SpotNoiseSource{.seed = seed}, ofMesh, ofMesh}};
  return edit;
}

SurfaceEdit perVertex(std::size_t values) {
  SurfaceEdit edit;
  edit.friction = FrictionEdit{Friction{0.6, 0.3, 0, PerVertexScale{}},
                               VertexValuesSource{GivenValues{std::vector<float>(values, 0.5F)}}};
  return edit;
}

SurfaceEdit shaded(std::vector<Crease> creases) {
  SurfaceEdit edit;
  edit.shading = Shading{0.5, std::move(creases)};
  return edit;
}

template <class T>
SurfaceEdit without(std::optional<std::optional<T>> SurfaceEdit::*property) {
  SurfaceEdit edit;
  (edit.*property).emplace();
  return edit;
}

class SurfaceEdits : public ::testing::Test {
 protected:
  SurfaceEdits() { accept(edit(add("a"))); }

  Accepted accept(const Transaction& transaction) {
    const EditOutcome outcome = sequencer.submit(1, ++seq, transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) ADD_FAILURE() << error->text();
    return std::get<Accepted>(outcome);
  }
  Error reject(const Transaction& transaction) {
    const auto before = sequencer.history();
    const EditOutcome outcome = sequencer.submit(1, ++seq, transaction);
    EXPECT_EQ(sequencer.history(), before) << "a rejected edit left a trace";
    const auto* error = std::get_if<Error>(&outcome);
    return error ? *error : Error{};
  }
  [[nodiscard]] ObjectRecord record(const std::string& name = "a") const {
    return *sequencer.history()->version.find(name);
  }
  [[nodiscard]] const ObjectAssets& assets() const { return sequencer.assetsOf(record().id); }
  [[nodiscard]] const MappedFamily& textureMap() {
    record_ = record();
    return std::get<MappedFamily>(record_.material.surface.texture->family);
  }

  BoxResolver resolver;
  Sequencer sequencer{5, resolver};
  std::uint64_t seq = 0;

 private:
  ObjectRecord record_;
};

TEST_F(SurfaceEdits, MakeTheFieldThatTheyAskForAndNameItInTheRecord) {
  const auto edit1 = accept(edit(setSurface(textured(7))));
  EXPECT_THAT(edit1->reports, ElementsAre("a: texture: computed"));
  EXPECT_EQ(textureMap().field, hashOf(BoxResolver::smallField(7)));
  ASSERT_THAT(assets().others, SizeIs(1));
  EXPECT_EQ(assets().others[0]->name, (AssetName{AssetKind::kScalarField, textureMap().field}));
  EXPECT_NE(assets().textureField, nullptr);
}

TEST_F(SurfaceEdits, KeepTheFieldsOfPropertiesThatTheyDoNotName) {
  accept(edit(setSurface(textured(7))));
  const auto field = assets().others[0];
  accept(edit(setSurface(shaded({})), moveTo("a", {1, 0, 0}), RemeshObject{named("a"), box(0.2)}));
  EXPECT_THAT(assets().others, ElementsAre(field));
  accept(edit(setSurface(without(&SurfaceEdit::texture))));
  EXPECT_THAT(assets().others, IsEmpty());
  EXPECT_EQ(assets().textureField, nullptr);
  EXPECT_TRUE(record().material.surface.shading);
}

TEST_F(SurfaceEdits, TakeTheLastOfWhatOneTransactionGives) {
  const int before = resolver.resolved;
  accept(edit(setSurface(textured(1)), setSurface(textured(2))));
  EXPECT_EQ(textureMap().field, hashOf(BoxResolver::smallField(2)));
  EXPECT_EQ(resolver.resolved, before + 1) << "the first is not made";
  accept(edit(setSurface(textured(3)), setSurface(without(&SurfaceEdit::texture))));
  EXPECT_FALSE(record().material.surface.texture);
}

TEST_F(SurfaceEdits, GiveAMappingTheBoxOfItsMeshWhereTheyLeaveItOut) {
  MappedFamily family = mapped();
  family.mapping.rotation = glm::angleAxis(glm::radians(45.0), Vec3(0, 0, 1));
  accept(edit(RemeshObject{named("a"), {BoxSource{Vec3(0.1, 0.1, 0.3), 1}}}, setSurface(textured(1, family, true))));
  const Mapping mapping = textureMap().mapping;
  EXPECT_NEAR(mapping.size_m.x, 0.1 * std::sqrt(2.0), 1e-7);
  EXPECT_NEAR(mapping.size_m.y, 0.1 * std::sqrt(2.0), 1e-7);
  EXPECT_NEAR(mapping.size_m.z, 0.3, 1e-7);
  EXPECT_NEAR(glm::length(mapping.centre), 0, 1e-7);
  accept(edit(setSurface(textured(1, mapped({1, 2, 3}, {4, 5, 6})))));
  EXPECT_EQ(textureMap().mapping.centre, Vec3(1, 2, 3));
  EXPECT_EQ(textureMap().mapping.size_m, Vec3(4, 5, 6));
}

TEST_F(SurfaceEdits, MayComeWithANewObject) {
  AddObject added{"b", box(), {}, {}};
  added.material.surface = textured(3);
  added.material.surface.friction = perVertex(kBoxVertices).friction;
  accept(edit(added));
  const ObjectAssets& its = sequencer.assetsOf(record("b").id);
  EXPECT_THAT(its.others, SizeIs(2));
  EXPECT_NE(its.frictionScale, nullptr);
  EXPECT_NE(its.textureField, nullptr);
}

TEST_F(SurfaceEdits, AreRefusedWithTheFieldThatCannotBeHad) {
  SurfaceEdit image = textured(1);
  (*image.texture)->source->field = FileSource{"missing.png"};
  EXPECT_EQ(reject(edit(setSurface(image))).field, "operations[0].set_material.material.texture.field.mapped.image");
  SurfaceEdit friction;
  friction.friction =
      FrictionEdit{Friction{1, 1, 0.5, FieldFamily{mapped()}}, MappedSource{AssetSource{}, false, false}};
  EXPECT_EQ(reject(edit(moveTo("a", {}), setSurface(friction))).field,
            "operations[1].set_material.material.friction.field.mapped.asset");
}

TEST_F(SurfaceEdits, AreRefusedWithAnotherNumberOfValuesThanVertices) {
  accept(edit(setSurface(perVertex(kBoxVertices))));
  const Error error = reject(edit(setSurface(perVertex(7))));
  EXPECT_EQ(error.field, "operations[0].set_material.material.friction.per_vertex");
  EXPECT_THAT(error.reason, HasSubstr("has 7 values; the mesh has 8 vertices"));
}

TEST_F(SurfaceEdits, ARemeshThatLeavesPerVertexValuesBehindIsRefused) {
  accept(edit(setSurface(perVertex(kBoxVertices))));
  const MeshSource finer{BoxSource{Vec3(0.1), 2}};
  const Error error = reject(edit(RemeshObject{named("a"), finer}));
  EXPECT_EQ(error.field, "operations[0].remesh.mesh");
  EXPECT_THAT(error.reason, HasSubstr("friction.per_vertex, which has 8 values"));
  EXPECT_THAT(error.reason, HasSubstr("same transaction"));

  accept(edit(RemeshObject{named("a"), finer}, setSurface(perVertex(26))));
  accept(edit(RemeshObject{named("a"), box()}, setSurface(without(&SurfaceEdit::friction))));
}

TEST_F(SurfaceEdits, AreRefusedWithACreaseThatIsNoLineOfTheMesh) {
  accept(edit(RemeshObject{named("a"), {BoxSource{Vec3(0.1), 4}}}));
  const TriangleIndices last = assets().mesh->mesh->triangles.back();
  const Crease line{std::min(last[0], last[1]), std::max(last[0], last[1])};
  ASSERT_GE(line[1], kBoxVertices);
  accept(edit(setSurface(shaded({line}))));
  for (const Crease& bad : {Crease{0, 1'000'000}, Crease{0, line[1]}}) {
    const Error error = reject(edit(setSurface(shaded({bad, line}))));
    EXPECT_EQ(error.field, "operations[0].set_material.material.shading.creases");
    EXPECT_THAT(error.reason, HasSubstr(std::to_string(bad[1])));
  }
  EXPECT_EQ(reject(edit(RemeshObject{named("a"), box()}, moveTo("a", {}))).field, "operations[0].remesh.mesh");
}

TEST_F(SurfaceEdits, AreRefusedWhereTheSceneHasNoRoomForTheirAssets) {
  const auto size = [&](const MeshSource& mesh) { return resolver.resolve(mesh)->asset->bytes().size(); };
  const MeshSource large{BoxSource{Vec3(1), 20}};
  Sequencer small(6, resolver, {.assets_bytes = size(box()) + size(large) + 80});
  auto fieldOf = [&, n = std::uint64_t{0}](const Transaction& transaction) mutable -> std::string {
    const EditOutcome outcome = small.submit(1, ++n, transaction);
    const auto* error = std::get_if<Error>(&outcome);
    return error ? error->field : "accepted";
  };
  EXPECT_EQ(fieldOf(edit(add("a"), add("twin"))), "accepted");
  EXPECT_EQ(fieldOf(edit(add("b", large), add("c", {BoxSource{Vec3(1), 2}}))), "operations[1].add.mesh.source");
  EXPECT_EQ(fieldOf(edit(add("b", large), add("twin of b", large))), "operations[1].add.name");
  EXPECT_EQ(fieldOf(edit(add("b", large), add("twin-of-b", large))), "accepted") << "what is shared counts once";
  EXPECT_EQ(fieldOf(edit(setSurface(textured(1)))), "accepted");
  EXPECT_EQ(fieldOf(edit(setSurface(textured(2), "twin"), setSurface(textured(3), "b"))),
            "operations[1].set_material.material.texture.field.mapped.source");
  EXPECT_EQ(fieldOf(edit(remove("b"), remove("twin-of-b"))), "accepted");
  EXPECT_EQ(fieldOf(edit(add("c", {BoxSource{Vec3(1), 2}}))), "accepted");
}

TEST_F(SurfaceEdits, AreRefusedWhereASnapshotOfTheSceneWouldNotFitAConnection) {
  SurfaceEdit waves;
  const FourierTerm wave{.amplitude = 1, .direction = {1, 0, 0}, .wavelength_m = 0.002, .phase_rad = 0};
  waves.texture = TextureEdit{Texture{.family = FourierFamily{std::vector(64, wave)}, .amplitude_m = 1e-4}, {}};
  Transaction many;
  constexpr std::size_t kMost = 5;
  Sequencer small(6, resolver, {.details_bytes = kMost * 64 * 64});
  for (std::size_t i = 0; i <= kMost; ++i) many.operations.push_back(add(numbered("o", i)));
  for (std::size_t i = 0; i < kMost; ++i) many.operations.push_back(setSurface(waves, numbered("o", i)));
  EXPECT_TRUE(std::holds_alternative<Accepted>(small.submit(1, 1, many)));
  const auto refused = small.submit(1, 2, edit(setSurface(waves, numbered("o", kMost))));
  ASSERT_TRUE(std::holds_alternative<Error>(refused));
  EXPECT_EQ(std::get<Error>(refused).field, "operations[0].set_material.material.texture");
  EXPECT_THAT(std::get<Error>(refused).reason, HasSubstr("20480"));
  EXPECT_TRUE(std::holds_alternative<Accepted>(
      small.submit(1, 3, edit(remove("o0"), setSurface(waves, numbered("o", kMost))))));
}

TEST_F(SurfaceEdits, LeadAMirrorToTheSameRoots) {
  SceneVersion mirror = sequencer.history()->version;
  for (const SurfaceEdit& surface :
       {textured(1), perVertex(kBoxVertices), shaded({}), without(&SurfaceEdit::texture), textured(2)}) {
    const auto accepted = accept(edit(setSurface(surface)));
    mirror = mirror.apply(accepted->commit).value();
    ASSERT_EQ(mirror.root(), accepted->commit.root);
  }
}

}  // namespace
}  // namespace haptics
