#include "common/surface/point_field_asset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace haptics::point_field_asset_test {
namespace {

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

PointField three() {
  return PointField::make(0.5F, {{{0, 0, 0}, 1}, {{0.25F, -1, 2}, -0.5F}, {{1e-3F, 0, 4}, 0}}).value();
}

std::string header(std::uint32_t count, std::uint32_t version = 1, float reach_m = 0.5F) {
  return "HPTF" + raw(version) + raw(count) + raw(reach_m);
}

std::string refusedField(std::string_view bytes) {
  const auto decoded = decodePointField(bytes);
  return decoded ? "accepted" : decoded.error().field;
}

TEST(PointFieldAsset, ComesBackFromItsBytesAsItWas) {
  const PointField back = decodePointField(encodePointField(three())).value();
  EXPECT_EQ(back.reach_m(), 0.5F);
  EXPECT_TRUE(std::ranges::equal(back.samples(), three().samples()));
}

TEST(PointFieldAsset, IsLaidOutAsDocumented) {
  std::string expected = header(3);
  for (const float number : {0.F, 0.F, 0.F, 1.F, 0.25F, -1.F, 2.F, -0.5F, 1e-3F, 0.F, 4.F, 0.F})
    expected += raw(number);
  EXPECT_EQ(encodePointField(three()), expected);
}

TEST(PointFieldAsset, IsHashedAsItsBytesAndAlikeFromVersionToVersion) {
  const std::string bytes = encodePointField(three());
  EXPECT_EQ(hashOf(three()), Hasher().add(std::as_bytes(std::span(bytes))).finish());
  EXPECT_EQ(hashOf(three()).hex(), "069b568694944abed13a3c6720d54b63ac6632b65d28aca14415af399d5b8990");
}

TEST(PointFieldAsset, IsRefusedWhenCutOffAnywhere) {
  const std::string bytes = encodePointField(three());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decodePointField(std::string_view(bytes).substr(0, size))) << size << " bytes";
  }
  EXPECT_EQ(refusedField(bytes + '\0'), "size");
}

TEST(PointFieldAsset, IsRefusedByTheFieldThatIsWrong) {
  const std::string samples(2 * sizeof(PointSample), '\0');
  EXPECT_EQ(refusedField(header(2) + samples), "accepted");
  EXPECT_EQ(refusedField("HPT"), "header");
  EXPECT_EQ(refusedField("HSFD" + header(2).substr(4) + samples), "magic");
  EXPECT_EQ(refusedField(header(2, 2) + samples), "version");
  EXPECT_EQ(refusedField(header(0) + samples), "count");
  EXPECT_EQ(refusedField(header(0xffffffff) + samples), "count");
  EXPECT_EQ(refusedField(header(60'001) + samples), "count");
  EXPECT_EQ(refusedField(header(60'000) + samples), "size");
  EXPECT_EQ(refusedField(header(2, 1, 0) + samples), "reach_m");
  const std::string nan = raw(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(refusedField(header(2) + nan + samples.substr(4)), "samples[0].point");
  EXPECT_EQ(refusedField(header(2) + samples.substr(4) + nan), "samples[1].value");
  EXPECT_EQ(refusedField(header(2) + raw(-0.0F) + samples.substr(4)), "samples[0].point");
}

}  // namespace
}  // namespace haptics::point_field_asset_test
