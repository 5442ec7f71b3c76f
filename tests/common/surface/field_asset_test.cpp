#include "common/surface/field_asset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace haptics::field_asset_test {
namespace {

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

SampledField ramp() { return SampledField::make(2, 3, {0, 0.25F, 0.5F, -1, 2, 3.5F}).value(); }

std::string header(std::uint32_t width, std::uint32_t height, std::uint32_t version = 1) {
  return "HSFD" + raw(version) + raw(width) + raw(height);
}

std::string refusedField(std::string_view bytes) {
  const auto decoded = decodeField(bytes);
  return decoded ? "accepted" : decoded.error().field;
}

TEST(FieldAsset, ComesBackFromItsBytesAsItWas) {
  const SampledField field = ramp();
  const SampledField back = decodeField(encodeField(field)).value();
  EXPECT_EQ(back.width(), 2U);
  EXPECT_EQ(back.height(), 3U);
  EXPECT_TRUE(std::ranges::equal(back.samples(), field.samples()));
}

TEST(FieldAsset, IsLaidOutAsDocumented) {
  std::string expected = header(2, 3);
  for (const float value : {0.F, 0.25F, 0.5F, -1.F, 2.F, 3.5F}) expected += raw(value);
  EXPECT_EQ(encodeField(ramp()), expected);
}

TEST(FieldAsset, IsHashedAsItsBytesAndAlikeFromVersionToVersion) {
  const std::string bytes = encodeField(ramp());
  EXPECT_EQ(hashOf(ramp()), Hasher().add(std::as_bytes(std::span(bytes))).finish());
  EXPECT_EQ(hashOf(ramp()).hex(), "c3e99339786f18d21a7263b328fc46a20201b1af201d398247174bd7ec8875d3");
}

TEST(FieldAsset, IsRefusedWhenCutOffAnywhere) {
  const std::string bytes = encodeField(ramp());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decodeField(std::string_view(bytes).substr(0, size))) << size << " bytes";
  }
  EXPECT_EQ(refusedField(bytes + '\0'), "size");
}

TEST(FieldAsset, IsRefusedByTheFieldThatIsWrong) {
  const std::string samples(4 * sizeof(float), '\0');
  EXPECT_EQ(refusedField(header(2, 2) + samples), "accepted");
  EXPECT_EQ(refusedField("HSF"), "header");
  EXPECT_EQ(refusedField("HMSH" + header(2, 2).substr(4) + samples), "magic");
  EXPECT_EQ(refusedField(header(2, 2, 2) + samples), "version");
  EXPECT_EQ(refusedField(header(1, 4) + samples), "width");
  EXPECT_EQ(refusedField(header(4, 1) + samples), "height");
  EXPECT_EQ(refusedField(header(0xffffffff, 0xffffffff) + samples), "width");
  EXPECT_EQ(refusedField(header(4096, 4096) + samples), "size");
  const std::string nan = raw(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(refusedField(header(2, 2) + nan + samples.substr(4)), "samples[0]");
}

}  // namespace
}  // namespace haptics::field_asset_test
