#include "graphics_client/application/texture_families.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <string>

#include "common/wire/convert_properties.h"
#include "graphics_client/application/texture_preview.h"

namespace haptics::texture_families_test {
namespace {

constexpr int kSide_px = 64;

FieldFamily familyOf(const TextureFamily& offered) {
  auto edit = fieldFrom(offered.make());
  EXPECT_TRUE(edit) << offered.name << ": " << edit.error().text();
  return edit ? edit->family : FieldFamily{};
}

const TextureFamily& offered(const std::string& name) {
  return *std::ranges::find(textureFamilies(), name, [](const TextureFamily& family) { return family.name; });
}

TEST(TextureFamilies, OfferEveryFamilyThatThereIs) {
  std::set<std::size_t> alternatives;
  std::set<std::string> names;
  for (const TextureFamily& family : textureFamilies()) {
    alternatives.insert(familyOf(family).index());
    names.insert(family.name);
  }
  EXPECT_EQ(alternatives.size(), std::variant_size_v<FieldFamily::variant>);
  EXPECT_EQ(names.size(), textureFamilies().size());
}

TEST(TextureFamilies, AreRecognisedInARecordThatTellsThem) {
  for (std::size_t i = 0; i < textureFamilies().size(); ++i) {
    const FieldFamily family = familyOf(textureFamilies()[i]);
    const bool isTold = family.index() < FieldFamily(MappedFamily{}).index();
    EXPECT_EQ(textureFamilyOf(family), isTold ? std::optional(i) : std::nullopt) << textureFamilies()[i].name;
  }
}

TEST(TextureFamilies, ScaleWithTheirSize) {
  for (const TextureFamily& family : textureFamilies()) {
    FieldFamily scaled = familyOf(family);
    if (std::holds_alternative<GrownFamily>(scaled)) {
      EXPECT_FALSE(textureSize_m(scaled));
      continue;
    }
    setTextureSize_m(scaled, 0.02);
    EXPECT_NEAR(textureSize_m(scaled).value(), 0.02, 1e-12) << family.name;
  }
  FieldFamily layers = familyOf(offered("rough waves"));
  setTextureSize_m(layers, 0.024);
  EXPECT_NEAR(textureSize_m(std::get<LayeredFamily>(layers).layers[1].family).value(), 0.008, 1e-12);
}

TEST(TextureFamilies, KeepWhatElseTheTextureIs) {
  SurfaceProperties surface;
  EXPECT_EQ(textureOf(surface).amplitude_m(), 3e-4);
  surface.texture = Texture{.law = Texture::Law::kBump, .family = NoiseFamily{0.01}, .amplitude_m = 2e-3};
  EXPECT_EQ(textureOf(surface).amplitude_m(), 2e-3);
  EXPECT_EQ(textureOf(surface).law(), v1::TEXTURE_LAW_BUMP);
  EXPECT_EQ(textureOf(surface).field().noise().wavelength_m(), 0.01);
}

TEST(TextureFamilies, OfAnImageIsMappedFromABox) {
  const auto edit = fieldFrom(imageField(ContentHash{{7}}));
  ASSERT_TRUE(edit) << edit.error().text();
  const auto& mapped = std::get<MappedFamily>(edit->family);
  EXPECT_EQ(mapped.field, ContentHash{{7}});
  EXPECT_EQ(mapped.mapping.shape, Mapping::Shape::kCube);
  EXPECT_TRUE(std::get<MappedSource>(edit->sources.at(0)).sizeOfMesh);
}

TEST(TexturePreview, IsAPictureOfItsOwnForEachFamily) {
  std::set<std::string> pictures;
  for (const TextureFamily& family : textureFamilies()) {
    const auto picture = texturePreview(family.make(), kSide_px);
    ASSERT_TRUE(picture) << family.name << ": " << picture.error().text();
    ASSERT_EQ(picture->size(), kSide_px * kSide_px);
    const auto [dark, bright] = std::ranges::minmax(*picture);
    EXPECT_GT(bright - dark, 60) << family.name << " is flat";
    pictures.emplace(picture->begin(), picture->end());
  }
  EXPECT_EQ(pictures.size(), textureFamilies().size());
}

/// The light comes from the upper left: what rises to the right is bright.
TEST(TexturePreview, IsLitFromTheUpperLeft) {
  const auto picture = texturePreview(offered("waves").make(), kSide_px).value();
  constexpr double kWave_px = kSide_px / 4.0;  // the middle of the picture is a crest
  const auto at = [&](double waves) {
    return picture[static_cast<std::size_t>(kSide_px / 2 * kSide_px + kSide_px / 2 + waves * kWave_px)];
  };
  EXPECT_GT(at(-0.25), at(0.25) + 60);
}

TEST(TexturePreview, OfARecordTakesItsSampledFields) {
  const FieldFamily mapped =
      MappedFamily{.field = ContentHash{{3}}, .mapping = {.shape = Mapping::Shape::kSphere, .tile_m = 0.02}};
  const auto field = std::make_shared<const SampledField>(SampledField::make(2, 2, {0, 1, 1, 0}).value());
  const auto lookup = [&](const ContentHash& hash) { return hash == ContentHash{{3}} ? field : nullptr; };
  EXPECT_TRUE(texturePreview(mapped, lookup, kSide_px));
  EXPECT_FALSE(texturePreview(
      mapped, [](const ContentHash&) { return nullptr; }, kSide_px));
  EXPECT_FALSE(texturePreview(GrownFamily{ContentHash{{3}}}, lookup, kSide_px));
}

}  // namespace
}  // namespace haptics::texture_families_test
