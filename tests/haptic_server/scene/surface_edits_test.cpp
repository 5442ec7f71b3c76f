#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "common/surface/field_asset.h"
#include "common/surface/make_field.h"
#include "common/surface/point_field_asset.h"
#include "haptic_server/scene/sequencer.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::surface_edits_test {
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

SurfaceEdit textured(std::uint32_t seed, MappedFamily family = mapped(), bool ofMesh = false) {
  SurfaceEdit edit;
  edit.texture = TextureEdit{Texture{.family = family, .amplitude_m = 1e-3},
                             {MappedSource{SpotNoiseSource{.seed = seed}, ofMesh, ofMesh}}};
  return edit;
}

MappedSource& mappedIn(FamilySource& source) { return std::get<MappedSource>(source); }

SurfaceEdit grown(std::uint32_t seed, double wavelength_m = 0.01) {
  SurfaceEdit edit;
  edit.texture = TextureEdit{Texture{.family = GrownFamily{}, .amplitude_m = 1e-3},
                             {GrownSource{GrownReactionDiffusionSource{.wavelength_m = wavelength_m, .seed = seed}}}};
  return edit;
}

SurfaceEdit perVertex(std::size_t values) {
  SurfaceEdit edit;
  edit.friction = FrictionEdit{Friction{0.6, 0.3, 0, PerVertexScale{}}, sameValues(0.5F, values)};
  return edit;
}

SurfaceEdit layered() {
  SurfaceEdit edit = perVertex(kBoxVertices);
  const LayeredFamily layers{LayeredFamily::Combination::kSum, {{1, mapped()}, {2, GrainFamily{0.001, 1}}}};
  const MappedSource source{SpotNoiseSource{.seed = 6}, true, true, 0};
  edit.texture = TextureEdit{Texture{.family = layers, .amplitude_m = 1e-3}, {source}};
  (*edit.friction)->friction.dynamicOver = FieldFamily{layers};
  (*edit.friction)->dynamicSource = std::vector<FamilySource>{source};
  return edit;
}

/// Stiffness over a computed field, softness by values per vertex.
SurfaceEdit varying(std::uint32_t seed, std::size_t values = kBoxVertices) {
  SurfaceEdit edit;
  edit.stiffnessOver = SurfaceMapEdit{
      SurfaceMap{0.5, mapped()}, std::vector<FamilySource>{MappedSource{SpotNoiseSource{.seed = seed}, true, true}}};
  edit.softnessOver = SurfaceMapEdit{SurfaceMap{0, PerVertexScale{}},
                                     VertexValuesSource{GivenValues{std::vector<float>(values, 0.25F)}}};
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

TEST_F(SurfaceEdits, MakeTheFieldsOfLayersAndFitThemToTheMesh) {
  SurfaceEdit surface;
  const LayeredFamily layers{LayeredFamily::Combination::kProduct,
                             {{1, mapped()}, {2, GrainFamily{0.001, 1}}, {3, mapped({}, Vec3(7))}}};
  surface.texture = TextureEdit{Texture{.family = layers, .amplitude_m = 1e-3},
                                {MappedSource{SpotNoiseSource{.seed = 3}, true, true, 0},
                                 MappedSource{SpotNoiseSource{.seed = 4}, false, false, 2}}};
  const auto accepted = accept(edit(setSurface(surface)));
  EXPECT_THAT(accepted->reports, ElementsAre("a: texture: computed", "a: texture: computed"));
  const auto texture = *record().material.surface.texture;
  const auto& made = std::get<LayeredFamily>(texture.family).layers;
  const auto& first = std::get<MappedFamily>(made[0].family);
  const auto& last = std::get<MappedFamily>(made[2].family);
  EXPECT_EQ(first.field, hashOf(BoxResolver::smallField(3)));
  EXPECT_NEAR(first.mapping.size_m.x, 0.1, 1e-7);
  EXPECT_EQ(last.field, hashOf(BoxResolver::smallField(4)));
  EXPECT_EQ(last.mapping.size_m, Vec3(7));
  EXPECT_THAT(assets().others, SizeIs(2));
  const auto own = [&](const FieldFamily& family) {
    return makeField(family,
                     [&](const ContentHash& hash) { return as<FieldAsset>(resolver.store().find(hash))->field; })
        .value();
  };
  const Vec3 place(0.03, 0.04, 0.05);
  EXPECT_DOUBLE_EQ(assets().textureField->at(place).value, 6 * own(made[0].family)->at(place).value *
                                                               own(made[1].family)->at(place).value *
                                                               own(made[2].family)->at(place).value);
  mappedIn((*surface.texture)->sources[1]).field = FileSource{"missing.png"};
  EXPECT_EQ(reject(edit(setSurface(surface))).field,
            "operations[0].set_material.material.texture.field.layers.layer[2].field.mapped.image");
}

TEST_F(SurfaceEdits, GrowAPatternOnTheMeshThatTheObjectHasAfterThem) {
  const auto accepted = accept(edit(setSurface(grown(7)), RemeshObject{named("a"), box(0.2)}));
  EXPECT_THAT(accepted->reports, ElementsAre("a: made", "a: texture: grown"));
  const PointField expected = BoxResolver::grownOn(makeBox(Vec3(0.2), 1).value(), 7).value();
  const AssetName name{AssetKind::kPointField, hashOf(expected)};
  EXPECT_EQ(record().assets()[1], name);
  ASSERT_THAT(assets().others, SizeIs(1));
  EXPECT_EQ(assets().others[0]->name, name);
  EXPECT_DOUBLE_EQ(assets().textureField->at(Vec3(0.1)).value, 7);
  accept(edit(RemeshObject{named("a"), box(0.3)}));
  EXPECT_EQ(record().assets()[1], name) << "it stays as it was grown";

  SurfaceEdit held = grown(1);
  std::get<GrownSource>((*held.texture)->sources[0]).points = AssetSource{name.hash};
  accept(edit(add("b"), setSurface(held, "b")));
  EXPECT_EQ(record("b").assets()[1], name);
}

TEST_F(SurfaceEdits, GrowInLayersAndOfFriction) {
  SurfaceEdit surface;
  const LayeredFamily layers{LayeredFamily::Combination::kSum, {{1, mapped()}, {10, GrownFamily{}}}};
  const GrownReactionDiffusionSource recipe{.wavelength_m = 0.01, .seed = 5};
  surface.texture = TextureEdit{Texture{.family = layers, .amplitude_m = 1e-3},
                                {MappedSource{SpotNoiseSource{.seed = 3}, true, true, 0}, GrownSource{recipe, 1}}};
  surface.friction =
      FrictionEdit{Friction{1, 1, 0.1, FieldFamily{GrownFamily{}}}, std::vector<FamilySource>{GrownSource{recipe}}};
  EXPECT_THAT(accept(edit(setSurface(surface)))->reports,
              ElementsAre("a: texture: computed", "a: friction: grown", "a: texture: grown"));
  const ContentHash points = hashOf(BoxResolver::grownOn(makeBox(Vec3(0.1), 1).value(), 5).value());
  const auto made = record().material.surface;
  EXPECT_EQ(std::get<GrownFamily>(std::get<LayeredFamily>(made.texture->family).layers[1].family).points, points);
  EXPECT_EQ(std::get<GrownFamily>(std::get<FieldFamily>(made.friction->over)).points, points);
  EXPECT_DOUBLE_EQ(assets().frictionField->at(Vec3(0.05)).value, 5);

  std::get<GrownSource>((*surface.texture)->sources[1]).points = GrownReactionDiffusionSource{.wavelength_m = 1e-4};
  EXPECT_EQ(reject(edit(setSurface(surface))).field,
            "operations[0].set_material.material.texture.field.layers.layer[1].field.grown.reaction_diffusion."
            "wavelength_m");
}

TEST_F(SurfaceEdits, GrowNothingOnAnObjectThatTheyRemove) {
  const int before = resolver.resolved;
  EXPECT_THAT(accept(edit(setSurface(grown(7)), remove("a")))->reports, IsEmpty());
  EXPECT_EQ(resolver.resolved, before);
}

TEST_F(SurfaceEdits, MakeTheMapOfTheDynamicCoefficientApartFromThatOfBoth) {
  SurfaceEdit surface = perVertex(kBoxVertices);
  FrictionEdit& given = **surface.friction;
  given.friction.dynamicOver = FieldFamily{mapped()};
  given.friction.dynamicVariation = 0.5;
  given.dynamicSource = std::vector<FamilySource>{MappedSource{SpotNoiseSource{.seed = 5}, true, true}};
  EXPECT_THAT(accept(edit(setSurface(surface)))->reports,
              ElementsAre("a: friction: taken", "a: dynamic friction: computed"));
  EXPECT_EQ(std::get<MappedFamily>(std::get<FieldFamily>(record().material.surface.friction->dynamicOver)).field,
            hashOf(BoxResolver::smallField(5)));
  EXPECT_THAT(assets().others, SizeIs(2));
  EXPECT_NE(assets().frictionScale, nullptr);
  EXPECT_EQ(assets().frictionField, nullptr);
  EXPECT_NE(assets().dynamicFrictionField, nullptr);
  EXPECT_EQ(assets().dynamicFrictionScale, nullptr);

  given.friction.dynamicOver = PerVertexScale{};
  given.friction.dynamicVariation = 0;
  given.dynamicSource = VertexValuesSource{GivenValues{std::vector<float>(7, 1)}};
  EXPECT_EQ(reject(edit(setSurface(surface))).field, "operations[0].set_material.material.friction.dynamic_per_vertex");
  given.dynamicSource = VertexValuesSource{GivenValues{std::vector<float>(kBoxVertices, 0.25F)}};
  accept(edit(setSurface(surface)));
  EXPECT_EQ((*assets().frictionScale->values)[0], 0.5F);
  EXPECT_EQ((*assets().dynamicFrictionScale->values)[0], 0.25F);
}

TEST_F(SurfaceEdits, MakeWhatStiffnessAndSoftnessFollow) {
  EXPECT_THAT(accept(edit(setSurface(varying(5))))->reports,
              ElementsAre("a: stiffness: computed", "a: softness: taken"));
  const auto stiffness = *record().material.surface.stiffnessOver;
  EXPECT_EQ(std::get<MappedFamily>(std::get<FieldFamily>(stiffness.over)).field, hashOf(BoxResolver::smallField(5)));
  EXPECT_NEAR(std::get<MappedFamily>(std::get<FieldFamily>(stiffness.over)).mapping.size_m.x, 0.1, 1e-7);
  EXPECT_THAT(assets().others, SizeIs(2));
  EXPECT_NE(assets().stiffnessField, nullptr);
  EXPECT_EQ(assets().stiffnessScale, nullptr);
  EXPECT_EQ(assets().softnessField, nullptr);
  EXPECT_EQ(*assets().softnessScale->values, std::vector<float>(kBoxVertices, 0.25F));

  const auto before = assets().others;
  accept(edit(setSurface(shaded({})), moveTo("a", {1, 0, 0})));
  EXPECT_EQ(assets().others, before);
  accept(edit(setSurface(without(&SurfaceEdit::stiffnessOver))));
  EXPECT_FALSE(record().material.surface.stiffnessOver);
  EXPECT_TRUE(record().material.surface.softnessOver);
  EXPECT_THAT(assets().others, SizeIs(1));
  EXPECT_EQ(assets().stiffnessField, nullptr);
}

TEST_F(SurfaceEdits, TakeTheLastMapThatOneTransactionGives) {
  const int before = resolver.resolved;
  accept(edit(setSurface(varying(5)), setSurface(varying(6))));
  EXPECT_EQ(resolver.resolved, before + 2) << "the first two are not made";
  accept(edit(setSurface(varying(7)), setSurface(without(&SurfaceEdit::softnessOver))));
  EXPECT_FALSE(record().material.surface.softnessOver);
  EXPECT_EQ(assets().softnessScale, nullptr);
}

TEST_F(SurfaceEdits, AreRefusedWhereAMapDoesNotFitTheMesh) {
  const std::string material = "operations[0].set_material.material.";
  EXPECT_EQ(reject(edit(setSurface(varying(5, 7)))).field, material + "softness_over.per_vertex");
  EXPECT_THAT(reject(edit(setSurface(varying(5, 9)))).reason, HasSubstr("has 9 values; the mesh has 8 vertices"));
  SurfaceEdit image = varying(5);
  mappedIn(std::get<std::vector<FamilySource>>((*image.stiffnessOver)->source)[0]).field = FileSource{"missing.png"};
  EXPECT_EQ(reject(edit(setSurface(image))).field, material + "stiffness_over.field.mapped.image");
  accept(edit(setSurface(varying(5))));
  const Error finer = reject(edit(RemeshObject{named("a"), MeshSource{BoxSource{Vec3(0.1), 2}}}));
  EXPECT_EQ(finer.field, "operations[0].remesh.mesh");
  EXPECT_THAT(finer.reason, HasSubstr("softness_over.per_vertex"));
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
  mappedIn((*image.texture)->sources.at(0)).field = FileSource{"missing.png"};
  EXPECT_EQ(reject(edit(setSurface(image))).field, "operations[0].set_material.material.texture.field.mapped.image");
  SurfaceEdit friction;
  friction.friction = FrictionEdit{Friction{1, 1, 0.5, FieldFamily{mapped()}},
                                   std::vector<FamilySource>{MappedSource{AssetSource{}, false, false}}};
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
  const auto size = [&](const MeshSource& mesh) { return resolver.resolve(mesh, 800)->asset->bytes().size(); };
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
  constexpr std::size_t kMax = 5;
  Sequencer small(6, resolver, {.details_bytes = kMax * 64 * 64});
  for (std::size_t i = 0; i <= kMax; ++i) many.operations.push_back(add(numbered("o", i)));
  for (std::size_t i = 0; i < kMax; ++i) many.operations.push_back(setSurface(waves, numbered("o", i)));
  EXPECT_TRUE(std::holds_alternative<Accepted>(small.submit(1, 1, many)));
  const auto refused = small.submit(1, 2, edit(setSurface(waves, numbered("o", kMax))));
  ASSERT_TRUE(std::holds_alternative<Error>(refused));
  EXPECT_EQ(std::get<Error>(refused).field, "operations[0].set_material.material.texture");
  EXPECT_THAT(std::get<Error>(refused).reason, HasSubstr("20480"));
  EXPECT_TRUE(
      std::holds_alternative<Accepted>(small.submit(1, 3, edit(remove("o0"), setSurface(waves, numbered("o", kMax))))));
}

TEST_F(SurfaceEdits, LeadAMirrorToTheSameRoots) {
  SceneVersion mirror = sequencer.history()->version;
  for (const SurfaceEdit& surface :
       {textured(1), varying(5), layered(), without(&SurfaceEdit::stiffnessOver), grown(4), perVertex(kBoxVertices),
        shaded({}), without(&SurfaceEdit::texture), textured(2)}) {
    const auto accepted = accept(edit(setSurface(surface)));
    mirror = mirror.apply(accepted->commit).value();
    ASSERT_EQ(mirror.root(), accepted->commit.root);
  }
}

}  // namespace
}  // namespace haptics::surface_edits_test
