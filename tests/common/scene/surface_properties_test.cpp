#include "common/scene/surface_properties.h"

#include <gmock/gmock.h>

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "common/scene/scene.h"

namespace haptics::surface_properties_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

ContentHash hashOf(std::uint64_t number) { return Hasher().add(number).finish(); }

ContentHash hashOf(const SurfaceProperties& properties) {
  Hasher hasher;
  addTo(hasher, properties);
  return hasher.finish();
}

FourierTerm wave() { return {.amplitude = 1, .direction = {1, 0, 0}, .wavelength_m = 0.002, .phase_rad = 0}; }

Mapping mapping() { return {Mapping::Shape::kSphere, {}, {1, 0, 0, 0}, Vec3(0.1), 0.01}; }

SurfaceProperties textured(FieldFamily family) {
  SurfaceProperties properties;
  properties.texture = Texture{.family = std::move(family), .amplitude_m = 5e-4};
  return properties;
}

SurfaceProperties rubbed(decltype(Friction::over) over) {
  SurfaceProperties properties;
  properties.friction = Friction{0.6, 0.3, 0.5, std::move(over)};
  return properties;
}

/// Each differs from all others, and all from a surface without properties.
std::vector<SurfaceProperties> different() {
  std::vector<SurfaceProperties> all(1);
  for (const Shading& shading : {Shading{0.5, {}}, Shading{0.6, {}}, Shading{0.5, {{1, 2}}}, Shading{0.5, {{1, 3}}},
                                 Shading{0.5, {{2, 3}}}, Shading{0.5, {{1, 2}, {2, 3}}}}) {
    all.emplace_back().shading = shading;
  }
  for (const Friction& friction : {Friction{0.6, 0.3, 0, {}}, Friction{0.7, 0.3, 0, {}}, Friction{0.6, 0.4, 0, {}}}) {
    all.emplace_back().friction = friction;
  }
  all.push_back(rubbed(FieldFamily{GrainFamily{0.001, 1}}));
  all.push_back(rubbed(FieldFamily{MappedFamily{hashOf(1), mapping()}}));
  all.push_back(rubbed(PerVertexScale{hashOf(1)}));
  all.push_back(rubbed(PerVertexScale{hashOf(2)}));
  all.push_back(rubbed(FieldFamily{GrainFamily{0.001, 1}}));
  all.back().friction->variation = 0.7;

  for (const FactorMap& over : {FactorMap{FieldFamily{GrainFamily{0.001, 1}}}, FactorMap{PerVertexScale{hashOf(1)}}}) {
    all.push_back(rubbed(std::monostate{}));
    all.back().friction->dynamicOver = over;
    all.push_back(all.back());
    all.back().friction->dynamicVariation = 0.7;
    all.push_back(rubbed(PerVertexScale{hashOf(1)}));
    all.back().friction->dynamicOver = over;
  }

  for (const auto map : {&SurfaceProperties::stiffnessOver, &SurfaceProperties::softnessOver}) {
    for (const SurfaceMap& over :
         {SurfaceMap{0.5, FieldFamily{GrainFamily{0.001, 1}}}, SurfaceMap{0.6, FieldFamily{GrainFamily{0.001, 1}}},
          SurfaceMap{0.5, FieldFamily{GrainFamily{0.002, 1}}}, SurfaceMap{0, PerVertexScale{hashOf(1)}},
          SurfaceMap{0, PerVertexScale{hashOf(2)}}}) {
      all.emplace_back().*map = over;
    }
  }

  const std::vector<std::function<void(LayeredFamily&)>> otherLayers = {
      [](LayeredFamily&) {},
      [](LayeredFamily& f) { f.combination = LayeredFamily::Combination::kProduct; },
      [](LayeredFamily& f) { f.layers[1].weight = 3; },
      [](LayeredFamily& f) {
        f.layers[1].family = GrainFamily{0.003, 1};
      },
      [](LayeredFamily& f) { std::swap(f.layers[0], f.layers[1]); },
      [](LayeredFamily& f) { f.layers.push_back(f.layers[0]); },
  };
  for (const auto& change : otherLayers) {
    LayeredFamily family{LayeredFamily::Combination::kSum, {{1, GrainFamily{0.001, 1}}, {2, GrainFamily{0.002, 1}}}};
    change(family);
    all.push_back(textured(family));
  }

  const std::vector<std::function<void(FourierTerm&)>> otherWaves = {
      [](FourierTerm&) {},
      [](FourierTerm& w) { w.amplitude = 2; },
      [](FourierTerm& w) {
        w.direction = {0, 1, 0};
      },
      [](FourierTerm& w) {
        w.direction = {0, 0, 1};
      },
      [](FourierTerm& w) { w.wavelength_m = 0.003; },
      [](FourierTerm& w) { w.phase_rad = 1; },
  };
  for (const auto& change : otherWaves) {
    FourierTerm term = wave();
    change(term);
    all.push_back(textured(FourierFamily{{term}}));
  }
  all.push_back(textured(FourierFamily{{wave(), wave()}}));
  for (const NoiseFamily& noise :
       {NoiseFamily{0.002, 1, 0.5, 1}, NoiseFamily{0.003, 1, 0.5, 1}, NoiseFamily{0.002, 2, 0.5, 1},
        NoiseFamily{0.002, 1, 0.6, 1}, NoiseFamily{0.002, 1, 0.5, 2}}) {
    all.push_back(textured(noise));
  }
  for (const CellularFamily& cells : {CellularFamily{0.002, 0.1, 1}, CellularFamily{0.003, 0.1, 1},
                                      CellularFamily{0.002, 0.2, 1}, CellularFamily{0.002, 0.1, 2}}) {
    all.push_back(textured(cells));
  }
  for (const GrainFamily& grain : {GrainFamily{0.002, 1}, GrainFamily{0.003, 1}, GrainFamily{0.002, 2}}) {
    all.push_back(textured(grain));
  }
  const std::vector<std::function<void(MappedFamily&)>> otherMaps = {
      [](MappedFamily&) {},
      [](MappedFamily& m) { m.field = hashOf(2); },
      [](MappedFamily& m) { m.mapping.shape = Mapping::Shape::kCube; },
      [](MappedFamily& m) { m.mapping.centre.y = 1; },
      [](MappedFamily& m) { m.mapping.rotation = Quat(0, 1, 0, 0); },
      [](MappedFamily& m) { m.mapping.rotation = Quat(0, 0, 1, 0); },
      [](MappedFamily& m) { m.mapping.size_m.z = 0.2; },
      [](MappedFamily& m) { m.mapping.tile_m = 0.02; },
  };
  for (const auto& change : otherMaps) {
    MappedFamily mapped{hashOf(1), mapping()};
    change(mapped);
    all.push_back(textured(mapped));
  }
  for (const std::uint64_t points : {1, 2}) all.push_back(textured(GrownFamily{hashOf(points)}));
  const std::vector<std::function<void(Texture&)>> otherTextures = {
      [](Texture& t) { t.law = Texture::Law::kBump; },
      [](Texture& t) { t.amplitude_m = 1e-3; },
      [](Texture& t) { t.literal = true; },
      [](Texture& t) { t.gain_K = 1; },
  };
  for (const auto& change : otherTextures) {
    SurfaceProperties properties = textured(FourierFamily{{wave()}});
    change(*properties.texture);
    all.push_back(properties);
  }
  return all;
}

TEST(SurfaceProperties, HashEveryField) {
  const auto all = different();
  std::map<ContentHash, std::size_t> seen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [at, fresh] = seen.emplace(hashOf(all[i]), i);
    EXPECT_TRUE(fresh) << i << " has the hash of " << at->second;
  }
}

TEST(SurfaceProperties, AreEqualWhereTheirHashesAre) {
  const auto all = different();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[i] == all[k], i == k) << i << ' ' << k;
  }
}

TEST(SurfaceProperties, ArePartOfTheirObjectsHash) {
  ObjectRecord plain;
  plain.id = 1;
  plain.name = "a";
  ObjectRecord shaded = plain;
  shaded.material.surface.shading = Shading{0.5, {}};
  EXPECT_NE(plain.hash(), shaded.hash());
}

TEST(SurfaceProperties, NameTheAssetsThatTheyRestOn) {
  ObjectRecord record;
  record.mesh = hashOf(7);
  EXPECT_THAT(record.assets(), ElementsAre(AssetName{AssetKind::kMesh, hashOf(7)}));
  record.material.surface = rubbed(PerVertexScale{hashOf(3)});
  record.material.surface.texture = textured(MappedFamily{hashOf(4), mapping()}).texture;
  EXPECT_THAT(record.assets(),
              ElementsAre(AssetName{AssetKind::kMesh, hashOf(7)}, AssetName{AssetKind::kVertexValues, hashOf(3)},
                          AssetName{AssetKind::kScalarField, hashOf(4)}));
  record.material.surface = rubbed(FieldFamily{MappedFamily{hashOf(5), mapping()}});
  EXPECT_THAT(assetsOf(record.material.surface), ElementsAre(AssetName{AssetKind::kScalarField, hashOf(5)}));
  EXPECT_THAT(assetsOf(textured(GrainFamily{0.001, 1})), IsEmpty());
}

TEST(SurfaceProperties, NameAndRenameTheAssetsOfLayersAndOfTheDynamicCoefficient) {
  const auto named = [](std::uint64_t number) { return MappedFamily{hashOf(number), mapping()}; };
  const LayeredFamily layers{LayeredFamily::Combination::kSum,
                             {{1, named(1)}, {2, GrainFamily{0.001, 1}}, {3, named(2)}}};
  SurfaceProperties properties = textured(layers);
  properties.friction = rubbed(FieldFamily{named(3)}).friction;
  properties.friction->dynamicOver = PerVertexScale{hashOf(4)};
  const auto field = [](std::uint64_t number) { return AssetName{AssetKind::kScalarField, hashOf(number)}; };
  EXPECT_THAT(assetsOf(properties),
              ElementsAre(field(3), AssetName{AssetKind::kVertexValues, hashOf(4)}, field(1), field(2)));
  const auto rename = [](const AssetName& name) { return Hasher().add(name.hash).finish(); };
  const SurfaceProperties anew = renamed(properties, rename);
  EXPECT_EQ(std::get<MappedFamily>(std::get<LayeredFamily>(anew.texture->family).layers[2].family).field,
            rename({AssetKind::kScalarField, hashOf(2)}));
  EXPECT_EQ(std::get<PerVertexScale>(anew.friction->dynamicOver).values, rename({AssetKind::kVertexValues, hashOf(4)}));
}

TEST(SurfaceProperties, NameAndRenameWhatIsGrownAlsoInALayer) {
  SurfaceProperties properties = textured(
      LayeredFamily{LayeredFamily::Combination::kSum, {{1, GrownFamily{hashOf(1)}}, {2, GrainFamily{0.001, 1}}}});
  properties.friction = rubbed(FieldFamily{GrownFamily{hashOf(2)}}).friction;
  const auto grown = [](std::uint64_t number) { return AssetName{AssetKind::kPointField, hashOf(number)}; };
  EXPECT_THAT(assetsOf(properties), ElementsAre(grown(2), grown(1)));
  const auto rename = [](const AssetName& name) { return Hasher().add(name.hash).finish(); };
  const SurfaceProperties anew = renamed(properties, rename);
  EXPECT_EQ(std::get<GrownFamily>(std::get<LayeredFamily>(anew.texture->family).layers[0].family).points,
            rename(grown(1)));
}

TEST(SurfaceProperties, HashFrictionWithoutAMapOfTheDynamicCoefficientAsBeforeThereWasOne) {
  Hasher before;
  before.add(std::uint64_t{2}).add(0.6).add(0.3).add(0.0).add(std::uint64_t{0});
  SurfaceProperties properties;
  properties.friction = Friction{0.6, 0.3, 0, {}};
  EXPECT_EQ(hashOf(properties), before.finish());
}

TEST(SurfaceProperties, NameAndRenameTheAssetsOfWhatStiffnessAndSoftnessFollow) {
  SurfaceProperties properties = rubbed(PerVertexScale{hashOf(1)});
  properties.stiffnessOver = SurfaceMap{0.5, FieldFamily{MappedFamily{hashOf(2), mapping()}}};
  properties.softnessOver = SurfaceMap{0, PerVertexScale{hashOf(3)}};
  EXPECT_THAT(assetsOf(properties),
              ElementsAre(AssetName{AssetKind::kVertexValues, hashOf(1)}, AssetName{AssetKind::kScalarField, hashOf(2)},
                          AssetName{AssetKind::kVertexValues, hashOf(3)}));
  const auto rename = [](const AssetName& name) { return Hasher().add(name.hash).finish(); };
  EXPECT_EQ(std::get<PerVertexScale>(renamed(properties, rename).softnessOver->over).values,
            rename({AssetKind::kVertexValues, hashOf(3)}));
}

TEST(SurfaceProperties, HashAsBeforeStiffnessCouldVaryWhereItDoesNot) {
  Hasher before;
  before.add(std::uint64_t{2}).add(0.6).add(0.3).add(0.5).add(std::uint64_t{2}).add(hashOf(1));
  before.add(std::uint64_t{3}).add(std::uint64_t{1});  // the texture's law, then grain
  before.add(std::uint64_t{3}).add(0.001).add(std::uint64_t{1}).add(5e-4).add(std::uint64_t{0}).add(1.5);
  SurfaceProperties properties = rubbed(PerVertexScale{hashOf(1)});
  properties.texture = textured(GrainFamily{0.001, 1}).texture;
  EXPECT_EQ(hashOf(properties), before.finish());
}

TEST(SurfaceEdit, ReplacesWhatItGivesWholeAndKeepsTheRest) {
  SurfaceProperties before = rubbed(std::monostate{});
  before.shading = Shading{0.5, {{1, 2}}};
  SurfaceEdit edit;
  EXPECT_EQ(edited(before, edit), before);
  edit.shading = Shading{0.7, {}};
  edit.texture = TextureEdit{Texture{.family = GrainFamily{0.001, 1}, .amplitude_m = 1e-4}, {}};
  const SurfaceProperties after = edited(before, edit);
  EXPECT_EQ(after.shading, (Shading{0.7, {}}));
  EXPECT_EQ(after.friction, before.friction);
  EXPECT_EQ(after.texture->amplitude_m, 1e-4);
}

TEST(SurfaceEdit, KeepsAMapOfWhichItSaysNothingAndTakesAwayOneThatItGivesAsNothing) {
  SurfaceProperties before;
  before.stiffnessOver = before.softnessOver = SurfaceMap{0.5, FieldFamily{GrainFamily{0.001, 1}}};
  SurfaceEdit edit;
  EXPECT_TRUE(edit.empty());
  edit.softnessOver.emplace();
  EXPECT_FALSE(edit.empty());
  EXPECT_EQ(edited(before, edit).stiffnessOver, before.stiffnessOver);
  EXPECT_FALSE(edited(before, edit).softnessOver);
  edit.softnessOver = SurfaceMapEdit{SurfaceMap{0, PerVertexScale{hashOf(1)}}};
  EXPECT_EQ(edited(before, edit).softnessOver, (SurfaceMap{0, PerVertexScale{hashOf(1)}}));
}

TEST(SurfaceEdit, TakesAwayWhatItGivesAsNothing) {
  SurfaceProperties before = rubbed(std::monostate{});
  before.shading = Shading{0.5, {}};
  before.texture = textured(GrainFamily{0.001, 1}).texture;
  SurfaceEdit edit;
  edit.friction.emplace();
  EXPECT_FALSE(edited(before, edit).friction);
  EXPECT_TRUE(edited(before, edit).texture);
  edit.shading.emplace();
  edit.texture.emplace();
  EXPECT_EQ(edited(before, edit), SurfaceProperties{});
}

}  // namespace
}  // namespace haptics::surface_properties_test
