#include "common/mesh/vertex_values.h"

#include <gmock/gmock.h>

#include <bit>
#include <cstring>
#include <limits>

namespace haptics::vertex_values_test {
namespace {

const std::vector<float> kValues{0.0F, 1.0F, 0.25F, 1e-30F, 9.5F};

std::string changed(std::size_t at, std::uint32_t to) {
  std::string bytes = encodeVertexValues(kValues);
  std::memcpy(bytes.data() + at, &to, sizeof to);
  return bytes;
}

std::string refusal(const std::string& bytes) {
  const auto values = decodeVertexValues(bytes);
  return values ? "accepted" : values.error().field;
}

TEST(VertexValues, ComeBackFromTheirCanonicalBytes) {
  const auto values = decodeVertexValues(encodeVertexValues(kValues));
  ASSERT_TRUE(values) << values.error().text();
  EXPECT_EQ(*values, kValues);
}

TEST(VertexValues, HaveOneFormForZero) {
  EXPECT_EQ(encodeVertexValues(std::vector<float>{-0.0F}), encodeVertexValues(std::vector<float>{0.0F}));
}

TEST(VertexValues, AreRefusedNamingWhatIsWrong) {
  const std::string good = encodeVertexValues(kValues);
  constexpr std::size_t kVersionAt = 4, kCountAt = 8, kFirstAt = 16;
  EXPECT_EQ(refusal(""), "magic");
  EXPECT_EQ(refusal(good.substr(0, kFirstAt - 1)), "magic");
  EXPECT_EQ(refusal(changed(0, 0)), "magic");
  EXPECT_EQ(refusal(changed(kVersionAt, 2)), "version");
  EXPECT_EQ(refusal(changed(kCountAt, 0)), "count");
  EXPECT_EQ(refusal(changed(kCountAt, 0xffffffff)), "count");
  EXPECT_EQ(refusal(changed(kCountAt, 6)), "size");
  EXPECT_EQ(refusal(good + "x"), "size");
  for (const float bad : {-1.0F, -0.0F, std::numeric_limits<float>::infinity(), std::nanf("")}) {
    EXPECT_EQ(refusal(changed(kFirstAt + 4, std::bit_cast<std::uint32_t>(bad))), "values[1]") << bad;
  }
}

}  // namespace
}  // namespace haptics::vertex_values_test
