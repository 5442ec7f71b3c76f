#include "graphics_client/viewer/contact_glyphs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TriMesh oneTriangle() { return {.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, .triangles = {{0, 1, 2}}}; }

TEST(ContactPrimitive, HasTheCornersThatItsNumbersName) {
  const TriMesh mesh = oneTriangle();
  const Vec3 a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kPolygon, 0, 0}, 0), ElementsAre(a, b, c));
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kLine, 0, 0}, 0), ElementsAre(a, b));
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kLine, 2, 0}, 0), ElementsAre(c, a));
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kVertex, 1, 0}, 0), ElementsAre(b));
}

TEST(ContactPrimitive, IsLiftedOutwards) {
  for (const Vec3& corner : primitiveCorners(oneTriangle(), {PrimitiveKind::kPolygon, 0, 0}, 0.25)) {
    EXPECT_DOUBLE_EQ(corner.z, 0.25);
  }
}

TEST(ContactPrimitive, IsNothingWhereTheMeshHasNoSuchPlace) {
  const TriMesh mesh = oneTriangle();
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kNone, 0, 0}, 0), IsEmpty());
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kPolygon, 0, 1}, 0), IsEmpty());
  EXPECT_THAT(primitiveCorners(mesh, {PrimitiveKind::kVertex, 3, 0}, 0), IsEmpty());
}

}  // namespace
}  // namespace haptics
