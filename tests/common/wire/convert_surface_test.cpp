#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <numbers>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"

namespace haptics::convert_surface_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::Material parse(const std::string& text) {
  v1::Material message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &message)) << text;
  return message;
}

SurfaceEdit edit(const std::string& text) {
  auto result = surfaceFrom(parse(text));
  EXPECT_TRUE(result) << result.error().text();
  return result ? *std::move(result) : SurfaceEdit{};
}

struct BadProperty {
  std::string text;    // of a material
  std::string field;   // that is named
  std::string reason;  // part of what is said
};

void PrintTo(const BadProperty& bad, std::ostream* out) { *out << bad.text; }

class RefusedProperty : public testing::TestWithParam<BadProperty> {};

TEST_P(RefusedProperty, NamesItsFieldAndWhatWouldBeRight) {
  const auto result = surfaceFrom(parse(GetParam().text));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, GetParam().field);
  EXPECT_THAT(result.error().reason, HasSubstr(GetParam().reason));
}

std::string texture(const std::string& family, const std::string& rest = "amplitude_m: 1e-3") {
  return "texture { " + rest + " field { " + family + " } }";
}
std::string wave(const std::string& rest) { return texture("fourier { terms { " + rest + " } }"); }
std::string mapped(const std::string& rest) { return texture("mapped { " + rest + " }"); }

const std::string kGrain = "grain { grain_m: 1e-3 }";
const std::string kPlane = " mapping { shape: MAPPING_SHAPE_PLANE tile_m: 0.01 }";
const std::string kField = "texture.field.";

INSTANTIATE_TEST_SUITE_P(Shading, RefusedProperty,
                         testing::ValuesIn(std::vector<BadProperty>{
                             {"shading { crease_rad: -0.1 }", "shading.crease_rad", "more than 0"},
                             {"shading { crease_rad: 3.2 }", "shading.crease_rad", "3.14"},
                             {"shading { crease_rad: nan }", "shading.crease_rad", "nan"},
                             {"shading { creases { first: 1 second: 2 } }", "shading.crease_rad", "more than 0"},
                             {"shading { crease_rad: 1 creases { first: 1 second: 2 } creases { first: 3 second: 3 } }",
                              "shading.creases[1]", "vertex 3 twice"}}));

INSTANTIATE_TEST_SUITE_P(
    Friction, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {"friction { mu_static: 0.3 mu_dynamic: 0.4 }", "friction.mu_dynamic", "at most mu_static"},
        {"friction { mu_dynamic: 0.4 }", "friction.mu_dynamic", "at most mu_static"},
        {"friction { mu_static: -1 }", "friction.mu_static", "0 to 10"},
        {"friction { mu_static: 11 }", "friction.mu_static", "0 to 10"},
        {"friction { mu_static: nan }", "friction.mu_static", "nan"},
        {"friction { mu_static: 1 mu_dynamic: -inf }", "friction.mu_dynamic", "0 to 10"},
        {"friction { mu_static: 1 variation: 0.5 }", "friction.variation", "give field"},
        {"friction { mu_static: 1 field { " + kGrain + " } }", "friction.variation", "change nothing"},
        {"friction { mu_static: 1 variation: nan field { " + kGrain + " } }", "friction.variation", "nan"},
        {"friction { mu_static: 1 variation: 1 field {} }", "friction.field.family", "give fourier"},
        {"friction { mu_static: 1 per_vertex {} }", "friction.per_vertex.source", "give values"},
        {"friction { mu_static: 1 per_vertex { asset: 'x' } }", "friction.per_vertex.asset", "32"},
        {"friction { mu_static: 1 per_vertex { values {} } }", "friction.per_vertex.values.value", "is empty"},
        {"friction { mu_static: 1 per_vertex { values { value: [1, -1] } } }", "friction.per_vertex.values.value[1]",
         "0 to 10"},
        {"friction { mu_static: 1 per_vertex { values { value: [nan] } } }", "friction.per_vertex.values.value[0]",
         "nan"}}));

INSTANTIATE_TEST_SUITE_P(
    Texture, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {texture(kGrain, ""), "texture.amplitude_m", "more than 0"},
        {texture(kGrain, "amplitude_m: -1e-3"), "texture.amplitude_m", "more than 0"},
        {texture(kGrain, "amplitude_m: inf"), "texture.amplitude_m", "inf"},
        {texture(kGrain, "amplitude_m: 0.2"), "texture.amplitude_m", "at most 0.1 m"},
        {texture(kGrain, "amplitude_m: 1e-3 gain_K: 0"), "texture.gain_K", "more than 0"},
        {texture(kGrain, "amplitude_m: 1e-3 gain_K: 1e-300"), "texture.gain_K", "at least 0.001: less has no effect"},
        {texture(kGrain, "amplitude_m: 1e-10"), "texture.amplitude_m", "at least 1e-09 m"},
        {texture(kGrain, "amplitude_m: 1e-3 gain_K: 2.1"), "texture.gain_K", "at most 2"},
        {texture(kGrain, "amplitude_m: 1e-3 law: 9"), "texture.law", "give TEXTURE_LAW_HO1999"},
        {"texture { amplitude_m: 1e-3 }", "texture.field.family", "give fourier"},
        {texture("fourier {}"), kField + "fourier.terms", "1 to 64"},
        {wave("wavelength_m: 1e-3"), kField + "fourier.terms[0].direction", "length 0"},
        {wave("direction { x: 2 } wavelength_m: 1e-3"), kField + "fourier.terms[0].direction", "length 2"},
        {wave("direction { x: nan } wavelength_m: 1e-3"), kField + "fourier.terms[0].direction", "nan"},
        {wave("direction { x: 1 }"), kField + "fourier.terms[0].wavelength_m", "is 0"},
        {wave("direction { x: 1 } wavelength_m: -1"), kField + "fourier.terms[0].wavelength_m", "1e-05 to"},
        {wave("direction { x: 1 } wavelength_m: nan"), kField + "fourier.terms[0].wavelength_m", "nan"},
        {wave("direction { x: 1 } wavelength_m: 1 amplitude: 0"), kField + "fourier.terms[0].amplitude",
         "leave it out"},
        {wave("direction { x: 1 } wavelength_m: 1 phase_rad: inf"), kField + "fourier.terms[0].phase_rad", "inf"},
        {texture("noise {}"), kField + "noise.wavelength_m", "is 0"},
        {texture("noise { wavelength_m: 1 octaves: 0 }"), kField + "noise.octaves", "1 to 12"},
        {texture("noise { wavelength_m: 1 octaves: 13 }"), kField + "noise.octaves", "1 to 12"},
        {texture("noise { wavelength_m: 1 persistence: 1.5 }"), kField + "noise.persistence", "to 1"},
        {texture("cellular {}"), kField + "cellular.cell_m", "is 0"},
        {texture("cellular { cell_m: 1 smoothness: 0 }"), kField + "cellular.smoothness", "0.001 to 1"},
        {texture("grain { grain_m: inf }"), kField + "grain.grain_m", "inf"}}));

INSTANTIATE_TEST_SUITE_P(
    Mapped, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {mapped(kPlane), kField + "mapped.source", "give image"},
        {mapped("image: ''" + kPlane), kField + "mapped.image", "is empty"},
        {mapped("image: '/a.png'" + kPlane), kField + "mapped.image", "absolute"},
        {mapped("image: 'a/../../b.png'" + kPlane), kField + "mapped.image", "leaves"},
        {mapped("asset: 'short'" + kPlane), kField + "mapped.asset", "has 5 bytes"},
        {mapped("image: 'a.png'"), kField + "mapped.mapping.shape", "give MAPPING_SHAPE_PLANE"},
        {mapped("image: 'a.png' mapping { shape: 7 }"), kField + "mapped.mapping.shape", "is 7"},
        {mapped("image: 'a.png' mapping { shape: MAPPING_SHAPE_CUBE }"), kField + "mapped.mapping.tile_m", "is 0"},
        {mapped("image: 'a.png' mapping { shape: MAPPING_SHAPE_CUBE tile_m: nan }"), kField + "mapped.mapping.tile_m",
         "nan"},
        {mapped("image: 'a.png' mapping { shape: MAPPING_SHAPE_CUBE tile_m: 1 centre { y: inf } }"),
         kField + "mapped.mapping.centre.y", "inf"},
        {mapped("image: 'a.png' mapping { shape: MAPPING_SHAPE_CUBE tile_m: 1 size_m { x: 1 y: 1 } }"),
         kField + "mapped.mapping.size_m.z", "more than 0"},
        {mapped("image: 'a.png' mapping { shape: MAPPING_SHAPE_CUBE tile_m: 1 rotation { w: 2 } }"),
         kField + "mapped.mapping.rotation", "unit quaternion"},
        {mapped("reaction_diffusion { pattern: 5 }" + kPlane), kField + "mapped.reaction_diffusion.pattern", "is 5"},
        {mapped("reaction_diffusion { cells: 33 }" + kPlane), kField + "mapped.reaction_diffusion.cells", "2 to 32"},
        {mapped("reaction_diffusion { resolution: 4000000000 }" + kPlane),
         kField + "mapped.reaction_diffusion.resolution", "32 to 1024"},
        {mapped("reaction_diffusion { cells: 32 resolution: 128 }" + kPlane),
         kField + "mapped.reaction_diffusion.resolution", "256 or more"},
        {mapped("spot_noise { elongation: 0.5 }" + kPlane), kField + "mapped.spot_noise.elongation", "1 to 8"},
        {mapped("spot_noise { cells: 1 }" + kPlane), kField + "mapped.spot_noise.cells", "2 to 32"}}));

const MappedSource& mappedIn(const FamilySource& source) { return std::get<MappedSource>(source); }

std::string grown(const std::string& rest) { return texture("grown { " + rest + " }"); }

INSTANTIATE_TEST_SUITE_P(Grown, RefusedProperty,
                         testing::ValuesIn(std::vector<BadProperty>{
                             {grown(""), kField + "grown.source", "give file, asset or reaction_diffusion"},
                             {grown("asset: 'short'"), kField + "grown.asset", "has 5 bytes"},
                             {grown("reaction_diffusion {}"), kField + "grown.reaction_diffusion.wavelength_m", "is 0"},
                             {grown("reaction_diffusion { wavelength_m: nan }"),
                              kField + "grown.reaction_diffusion.wavelength_m", "nan"},
                             {grown("reaction_diffusion { wavelength_m: -1e-3 }"),
                              kField + "grown.reaction_diffusion.wavelength_m", "1e-05 to"},
                             {grown("reaction_diffusion { wavelength_m: 1e-3 pattern: 5 }"),
                              kField + "grown.reaction_diffusion.pattern", "is 5"}}));

std::string layers(const std::string& rest) { return texture("layers { " + rest + " }"); }
std::string layer(const std::string& family, const std::string& rest = "") {
  return " layer { " + rest + " field { " + family + " } }";
}
const std::string kLayers = kField + "layers.layer";

INSTANTIATE_TEST_SUITE_P(
    Layered, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {layers(""), kLayers, "has 0 entries; give 2 to 4"},
        {layers(layer(kGrain)), kLayers, "has 1 entries; give 2 to 4"},
        {layers(layer(kGrain) + layer(kGrain) + layer(kGrain) + layer(kGrain) + layer(kGrain)), kLayers,
         "has 5 entries; give 2 to 4"},
        {layers("combination: 3" + layer(kGrain) + layer(kGrain)), kField + "layers.combination",
         "is 3; give LAYER_COMBINATION_SUM"},
        {layers(layer(kGrain) + layer(kGrain, "weight: nan")), kLayers + "[1].weight", "is nan; give -1000 to 1000"},
        {layers(layer(kGrain, "weight: -inf") + layer(kGrain)), kLayers + "[0].weight", "-1000 to 1000"},
        {layers(layer(kGrain, "weight: 1001") + layer(kGrain)), kLayers + "[0].weight", "-1000 to 1000"},
        {layers(layer(kGrain, "weight: 0") + layer(kGrain)), kLayers + "[0].weight", "leave the layer out"},
        {layers(layer(kGrain) + layer("layers {" + layer(kGrain) + layer(kGrain) + "}")), kLayers + "[1].field.layers",
         "is layered within a layer; give a layer a field of another family"},
        {layers(layer(kGrain) + layer("")), kLayers + "[1].field.family", "give fourier"},
        {layers(layer("mapped {" + kPlane + "}") + layer(kGrain)), kLayers + "[0].field.mapped.source", "give image"},
        {"friction { mu_static: 1 variation: 1 field { layers {" + layer(kGrain) + layer("noise {}") + "} } }",
         "friction.field.layers.layer[1].field.noise.wavelength_m", "is 0"}}));

INSTANTIATE_TEST_SUITE_P(
    DynamicFriction, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {"friction { mu_static: 1 dynamic_variation: 0.5 }", "friction.dynamic_variation", "give dynamic_field"},
        {"friction { mu_static: 1 dynamic_field { " + kGrain + " } }", "friction.dynamic_variation", "change nothing"},
        {"friction { mu_static: 1 dynamic_variation: 11 dynamic_field { " + kGrain + " } }",
         "friction.dynamic_variation", "-10 to 10"},
        {"friction { mu_static: 1 dynamic_variation: nan dynamic_field { " + kGrain + " } }",
         "friction.dynamic_variation", "nan"},
        {"friction { mu_static: 1 dynamic_variation: 1 dynamic_field {} }", "friction.dynamic_field.family",
         "give fourier"},
        {"friction { mu_static: 1 dynamic_per_vertex {} }", "friction.dynamic_per_vertex.source", "give values"},
        {"friction { mu_static: 1 dynamic_per_vertex { values { value: [1, nan] } } }",
         "friction.dynamic_per_vertex.values.value[1]", "nan"}}));

std::string over(const std::string& rest) { return "stiffness_over { " + rest + " }"; }

INSTANTIATE_TEST_SUITE_P(
    StiffnessAndSoftness, RefusedProperty,
    testing::ValuesIn(std::vector<BadProperty>{
        {over("variation: 0.5"), "stiffness_over.variation", "give field"},
        {over("field { " + kGrain + " }"), "stiffness_over.variation", "change nothing"},
        {over("variation: nan field { " + kGrain + " }"), "stiffness_over.variation", "nan"},
        {over("variation: -11 field { " + kGrain + " }"), "stiffness_over.variation", "-10 to 10"},
        {over("variation: 1 field {}"), "stiffness_over.field.family", "give fourier"},
        {over("variation: 1 field { noise {} }"), "stiffness_over.field.noise.wavelength_m", "is 0"},
        {over("variation: 1 per_vertex { values { value: 1 } }"), "stiffness_over.variation", "give field"},
        {over("per_vertex {}"), "stiffness_over.per_vertex.source", "give values"},
        {over("per_vertex { values {} }"), "stiffness_over.per_vertex.values.value", "is empty"},
        {over("per_vertex { values { value: [1, 11] } }"), "stiffness_over.per_vertex.values.value[1]", "0 to 10"},
        {"softness_over { per_vertex { values { value: [1, nan] } } }", "softness_over.per_vertex.values.value[1]",
         "nan"},
        {"softness_over { variation: inf field { " + kGrain + " } }", "softness_over.variation", "inf"}}));

TEST(SurfaceProperty, OfAStiffnessThatVariesIsTakenAwayByAnEmptyMessageAndKeptByNone) {
  const SurfaceEdit given = edit("stiffness_over {} softness_over { per_vertex { values { value: [1, 0.5] } } }");
  EXPECT_TRUE(given.stiffnessOver && !*given.stiffnessOver);
  const auto& source = std::get<VertexValuesSource>((*given.softnessOver)->source);
  EXPECT_THAT(std::get<GivenValues>(source).values, ElementsAre(1, 0.5));
  const SurfaceEdit none = edit("texture {}");
  EXPECT_FALSE(none.stiffnessOver || none.softnessOver);
}

TEST(SurfaceProperty, OfAStiffnessThatVariesComesWithDirectionsOfUnitLength) {
  const SurfaceEdit given =
      edit(over("variation: 1 field { fourier { terms { direction { x: 0.6005 y: 0.8 } wavelength_m: 1 } } }"));
  const auto& family = std::get<FieldFamily>((*given.stiffnessOver)->map.over);
  EXPECT_NEAR(glm::length(std::get<FourierFamily>(family).terms[0].direction), 1, 1e-15);
}

TEST(SurfaceProperty, MayKeepTheDynamicCoefficientConstantWhereTheStaticOneVaries) {
  const SurfaceEdit given =
      edit("friction { mu_static: 1 variation: 1 field { " + kGrain + " } dynamic_field { " + kGrain + " } }");
  EXPECT_EQ((*given.friction)->friction.dynamicVariation, 0);
  EXPECT_TRUE(std::holds_alternative<FieldFamily>((*given.friction)->friction.dynamicOver));
}

TEST(SurfaceProperty, CarriesWhereTheFieldsOfItsLayersComeFrom) {
  const SurfaceEdit given = edit(layers(layer("mapped { image: 'a.png'" + kPlane + "}") + layer(kGrain, "weight: -2") +
                                        layer("mapped { spot_noise { seed: 9 }" + kPlane + "}")));
  const auto& family = std::get<LayeredFamily>((*given.texture)->texture.family);
  ASSERT_EQ(family.layers.size(), 3U);
  EXPECT_EQ(family.combination, LayeredFamily::Combination::kSum);
  EXPECT_EQ(family.layers[0].weight, 1);
  EXPECT_EQ(family.layers[1].weight, -2);
  const auto& sources = (*given.texture)->sources;
  ASSERT_EQ(sources.size(), 2U);
  EXPECT_EQ(std::get<FileSource>(mappedIn(sources[0]).field).path, "a.png");
  EXPECT_EQ(layerOf(sources[0]), 0U);
  EXPECT_EQ(std::get<SpotNoiseSource>(mappedIn(sources[1]).field).seed, 9U);
  EXPECT_EQ(layerOf(sources[1]), 2U);
}

TEST(SurfaceProperty, CarriesWhatIsToGrowAlsoInALayer) {
  const std::string spots = "grown { reaction_diffusion { wavelength_m: 2e-3 } }";
  const std::string stripes =
      "grown { reaction_diffusion { pattern: REACTION_DIFFUSION_PATTERN_STRIPES wavelength_m: 3e-3 seed: 9 } }";
  const SurfaceEdit alone = edit(texture(spots));
  using Pattern = ReactionDiffusionSource::Pattern;
  const auto recipeIn = [](const FamilySource& source) {
    return std::get<GrownReactionDiffusionSource>(std::get<GrownSource>(source).points);
  };
  EXPECT_EQ(recipeIn((*alone.texture)->sources.at(0)), (GrownReactionDiffusionSource{Pattern::kSpots, 2e-3, 1}));
  EXPECT_TRUE(std::get<GrownFamily>((*alone.texture)->texture.family).points.isZero());
  EXPECT_EQ(fieldName((*alone.texture)->sources.at(0)), "grown");
  const SurfaceEdit layered = edit(layers(layer(kGrain) + layer(stripes)));
  EXPECT_EQ(recipeIn((*layered.texture)->sources.at(0)), (GrownReactionDiffusionSource{Pattern::kStripes, 3e-3, 9}));
  EXPECT_EQ(fieldName((*layered.texture)->sources.at(0)), "layers.layer[1].field.grown");
  const SurfaceEdit held = edit(texture("grown { asset: '0123456789abcdef0123456789abcdef' }"));
  EXPECT_EQ(std::get<GrownFamily>((*held.texture)->texture.family).points.asBytes(),
            "0123456789abcdef0123456789abcdef");
}

TEST(SurfaceProperty, ComesWithDirectionsOfUnitLengthInItsLayers) {
  const SurfaceEdit given =
      edit(layers(layer(kGrain) + layer("fourier { terms { direction { x: 0.6005 y: 0.8 } wavelength_m: 1 } }")));
  const auto& family = std::get<LayeredFamily>((*given.texture)->texture.family);
  EXPECT_NEAR(glm::length(std::get<FourierFamily>(family.layers[1].family).terms[0].direction), 1, 1e-15);
}

TEST(SurfaceProperty, IsRefusedWithMoreCreasesThanMayBeNamed) {
  v1::Material message = parse("shading { crease_rad: 1 }");
  for (std::uint32_t i = 0; i < kMaxCreases; ++i) message.mutable_shading()->add_creases()->set_first(i + 1);
  EXPECT_TRUE(surfaceFrom(message));
  message.mutable_shading()->add_creases()->set_first(7);
  const auto tooMany = surfaceFrom(message);
  ASSERT_FALSE(tooMany);
  EXPECT_EQ(tooMany.error().field, "shading.creases");
}

TEST(SurfaceProperty, IsRefusedInsideItsOperation) {
  v1::Transaction transaction;
  v1::SetMaterial& set = *transaction.add_operations()->mutable_set_material();
  set.mutable_object()->set_name("a");
  *set.mutable_material() = parse("friction { mu_static: -1 }");
  const auto result = fromWire(transaction);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().field, "operations[0].set_material.material.friction.mu_static");
}

TEST(SurfaceProperty, IsTakenAwayByAnEmptyMessageAndKeptByNone) {
  const SurfaceEdit none = edit("stiffness_N_per_m: 500");
  EXPECT_TRUE(none.empty());
  const SurfaceEdit away = edit("shading {} friction {} texture {}");
  EXPECT_TRUE(away.shading && !*away.shading);
  EXPECT_TRUE(away.friction && !*away.friction);
  EXPECT_TRUE(away.texture && !*away.texture);
}

TEST(SurfaceProperty, NamesEachCreaseOnceInOrder) {
  const SurfaceEdit given = edit(
      "shading { crease_rad: 1 creases { first: 9 second: 4 } creases { first: 2 second: 5 } creases { first: 4 "
      "second: 9 } creases { first: 2 second: 3 } }");
  EXPECT_THAT((*given.shading)->creases, ElementsAre(Crease{2, 3}, Crease{2, 5}, Crease{4, 9}));
}

TEST(SurfaceProperty, ComesWithItsDefaults) {
  const SurfaceEdit given = edit(texture("noise { wavelength_m: 2e-3 }"));
  const Texture& t = (*given.texture)->texture;
  EXPECT_EQ(t.law, Texture::Law::kHo1999);
  EXPECT_EQ(t.gain_K, 1.5);
  EXPECT_FALSE(t.literal);
  EXPECT_EQ(std::get<NoiseFamily>(t.family), (NoiseFamily{2e-3, 1, 0.5, 1}));
  const SurfaceEdit computed = edit(mapped("reaction_diffusion {}" + kPlane));
  EXPECT_EQ(std::get<ReactionDiffusionSource>(mappedIn((*computed.texture)->sources.at(0)).field),
            ReactionDiffusionSource{});
  EXPECT_TRUE(std::get<MappedFamily>((*computed.texture)->texture.family).field.isZero());
}

TEST(SurfaceProperty, ComesWithDirectionsOfUnitLength) {
  const SurfaceEdit given = edit(wave("direction { x: 0.6005 y: 0.8 } wavelength_m: 1e-3"));
  const auto& family = std::get<FourierFamily>((*given.texture)->texture.family);
  EXPECT_NEAR(glm::length(family.terms[0].direction), 1, 1e-15);
  EXPECT_EQ(family.terms[0].amplitude, 1);
}

TEST(SurfaceProperty, CarriesWhereItsFieldComesFrom) {
  const SurfaceEdit image = edit(mapped("image: 'maps/a.png'" + kPlane));
  EXPECT_EQ(std::get<FileSource>(mappedIn((*image.texture)->sources.at(0)).field).path, "maps/a.png");
  const SurfaceEdit spots = edit(mapped("spot_noise { cells: 20 elongation: 3 resolution: 512 seed: 9 }" + kPlane));
  EXPECT_EQ(std::get<SpotNoiseSource>(mappedIn((*spots.texture)->sources.at(0)).field),
            (SpotNoiseSource{20, 3, 512, 9}));
  const SurfaceEdit values = edit("friction { mu_static: 1 per_vertex { values { value: [1, 0.5, 0] } } }");
  const auto& source = std::get<VertexValuesSource>((*values.friction)->source);
  EXPECT_THAT(std::get<GivenValues>(source).values, ElementsAre(1, 0.5, 0));
}

TEST(SurfaceProperty, LeavesTheSizeAndCentreOfItsMappingToTheMesh) {
  const std::string base = "image: 'a' mapping { shape: MAPPING_SHAPE_SPHERE tile_m: 1 ";
  const auto source = [&](const std::string& rest) {
    return mappedIn((*edit(mapped(base + rest + "}")).texture)->sources.at(0));
  };
  EXPECT_TRUE(source("").centreOfMesh && source("").sizeOfMesh);
  EXPECT_TRUE(!source("centre {}").centreOfMesh && source("centre {}").sizeOfMesh);
  const std::string size = "size_m { x: 1 y: 2 z: 3 }";
  EXPECT_TRUE(source(size).centreOfMesh && !source(size).sizeOfMesh);
}

// ---- What is announced ----

ContentHash hash(std::uint64_t number) { return Hasher().add(number).finish(); }

std::vector<FieldFamily> families() {
  const double third = 1.0 / 3;
  FourierFamily fourier;
  for (int i = 1; i <= 3; ++i)
    fourier.terms.push_back({third * i, {third, -2 * third, 2 * third}, third * 1e-3, -third});
  const MappedFamily mapped{hash(1),
                            {Mapping::Shape::kSphere, {third, 0, -third}, {0.6, 0, 0.8, 1e-4}, {third, 1, 2}, third}};
  return {fourier,
          NoiseFamily{third, 3, third, 0},
          CellularFamily{third, third, 7},
          GrainFamily{third, 0xffffffff},
          mapped,
          LayeredFamily{LayeredFamily::Combination::kSum, {{third, mapped}, {-third, GrainFamily{third, 1}}}},
          LayeredFamily{LayeredFamily::Combination::kProduct, {{1, fourier}, {3, mapped}, {-1, mapped}}},
          GrownFamily{hash(5)},
          LayeredFamily{LayeredFamily::Combination::kSum, {{1, GrownFamily{hash(6)}}, {third, mapped}}}};
}

void comesBackBitForBit(const SurfaceProperties& properties) {
  v1::ObjectState sent, arrived;
  toWire(properties, sent);
  ASSERT_TRUE(arrived.ParseFromString(sent.SerializeAsString()));
  const auto back = surfaceFrom(arrived);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(*back, properties) << sent.DebugString();
}

TEST(AnnouncedSurface, ComesBackBitForBit) {
  SurfaceProperties p;
  comesBackBitForBit(p);
  p.shading = Shading{std::numbers::pi, {{1, 2}, {7, 9}}};
  comesBackBitForBit(p);
  p.friction = Friction{};
  comesBackBitForBit(p);
  p.friction = Friction{0.7, 0.1, 0, PerVertexScale{hash(2)}};
  comesBackBitForBit(p);
  for (const FieldFamily& family : families()) {
    p.friction = Friction{0.7, 1.0 / 3, -1.0 / 3, family};
    p.texture = Texture{Texture::Law::kBump, family, 1e-3 / 3, true, 2.0 / 3};
    comesBackBitForBit(p);
    p.friction->dynamicOver = family;
    comesBackBitForBit(p);
    p.friction->dynamicVariation = 1.0 / 7;
    comesBackBitForBit(p);
    p.friction = Friction{0.7, 0.1, 0, PerVertexScale{hash(2)}, 0, PerVertexScale{hash(3)}};
    comesBackBitForBit(p);
    p.stiffnessOver = SurfaceMap{-1.0 / 3, family};
    comesBackBitForBit(p);
    p.softnessOver = SurfaceMap{0, PerVertexScale{hash(4)}};
    comesBackBitForBit(p);
    std::swap(p.stiffnessOver, p.softnessOver);
    comesBackBitForBit(p);
  }
}

TEST(AnnouncedSurface, IsNoLongerThereWhereAMessageIsUsedAnew) {
  SurfaceProperties p;
  p.shading = Shading{1, {}};
  p.friction = Friction{};
  p.texture = Texture{.family = GrainFamily{1e-3, 1}, .amplitude_m = 1e-3};
  p.stiffnessOver = p.softnessOver = SurfaceMap{0, PerVertexScale{hash(1)}};
  v1::ObjectState message;
  toWire(p, message);
  toWire(SurfaceProperties{}, message);
  EXPECT_EQ(*surfaceFrom(message), SurfaceProperties{});
}

TEST(AnnouncedSurface, IsRefusedWhereItNamesNoAsset) {
  const auto refusal = [](const std::string& text) {
    v1::ObjectState message;
    const v1::Material material = parse(text);
    if (material.has_texture()) *message.mutable_texture() = material.texture();
    if (material.has_friction()) *message.mutable_friction() = material.friction();
    if (material.has_stiffness_over()) *message.mutable_stiffness_over() = material.stiffness_over();
    if (material.has_softness_over()) *message.mutable_softness_over() = material.softness_over();
    const auto result = surfaceFrom(message);
    return result ? "accepted" : result.error().field;
  };
  EXPECT_EQ(refusal(mapped("image: 'a.png'" + kPlane)), "texture.field.mapped.source");
  EXPECT_EQ(refusal(mapped("spot_noise {}" + kPlane)), "texture.field.mapped.source");
  const std::string asset = "asset: '0123456789abcdef0123456789abcdef' mapping { shape: MAPPING_SHAPE_CUBE tile_m: 1 ";
  EXPECT_EQ(refusal(mapped(asset + "}")), "texture.field.mapped.mapping.centre");
  EXPECT_EQ(refusal(mapped(asset + "centre {} }")), "texture.field.mapped.mapping.size_m");
  EXPECT_EQ(refusal(mapped(asset + "centre {} size_m { x: 1 y: 1 z: 1 } }")), "accepted");
  EXPECT_EQ(refusal("friction { mu_static: 1 variation: 1 field { mapped { image: 'a' " + kPlane + " } } }"),
            "friction.field.mapped.source");
  EXPECT_EQ(refusal("friction { mu_static: 1 per_vertex { values { value: 1 } } }"), "friction.per_vertex.source");
  EXPECT_EQ(refusal("friction { mu_static: 1 dynamic_per_vertex { values { value: 1 } } }"),
            "friction.dynamic_per_vertex.source");
  EXPECT_EQ(
      refusal("friction { mu_static: 1 dynamic_variation: 1 dynamic_field { mapped { image: 'a' " + kPlane + " } } }"),
      "friction.dynamic_field.mapped.source");
  EXPECT_EQ(refusal(layers(layer(kGrain) + layer("mapped { " + asset + "centre {} } }"))),
            "texture.field.layers.layer[1].field.mapped.mapping.size_m");
  EXPECT_EQ(refusal(grown("reaction_diffusion { wavelength_m: 1e-3 }")), "texture.field.grown.source");
  EXPECT_EQ(refusal(grown("asset: '0123456789abcdef0123456789abcdef'")), "accepted");
  EXPECT_EQ(refusal("texture { amplitude_m: nan }"), "texture.amplitude_m");
  EXPECT_EQ(refusal(over("variation: 1 field { mapped { image: 'a' " + kPlane + " } }")),
            "stiffness_over.field.mapped.source");
  EXPECT_EQ(refusal("softness_over { per_vertex { values { value: 1 } } }"), "softness_over.per_vertex.source");
  EXPECT_EQ(refusal("softness_over {}"), "softness_over.over");
  EXPECT_EQ(refusal("friction { mu_static: nan }"), "friction.mu_static");
}

}  // namespace
}  // namespace haptics::convert_surface_test
