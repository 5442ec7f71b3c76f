#include "graphics_client/viewer/contact_glyphs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics::contact_glyphs_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::array kTriangle{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)};

TEST(ContactPrimitive, HasTheCornersThatItsNumbersName) {
  const auto [a, b, c] = kTriangle;
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kPolygon, 0, 0}, 0), ElementsAre(a, b, c));
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kLine, 0, 0}, 0), ElementsAre(a, b));
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kLine, 2, 0}, 0), ElementsAre(c, a));
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kVertex, 1, 0}, 0), ElementsAre(b));
}

TEST(ContactPrimitive, IsLiftedOutwards) {
  for (const Vec3& corner : primitiveCorners(kTriangle, {PrimitiveKind::kPolygon, 0, 0}, 0.25)) {
    EXPECT_DOUBLE_EQ(corner.z, 0.25);
  }
}

TEST(ContactPrimitive, IsNothingWhereThereIsNoSuchPlace) {
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kNone, 0, 0}, 0), IsEmpty());
  EXPECT_THAT(primitiveCorners(kTriangle, {PrimitiveKind::kVertex, 3, 0}, 0), IsEmpty());
}

}  // namespace
}  // namespace haptics::contact_glyphs_test
