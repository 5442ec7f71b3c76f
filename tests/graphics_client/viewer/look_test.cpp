#include "graphics_client/viewer/look.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics {
namespace {

constexpr std::size_t kPlenty = 100'000;
constexpr double kSide_m = 0.05;

LookOrder orderFor(const TriMesh& mesh) {
  return {.mesh = hashOf(mesh),
          .surface = {},
          .mostTriangles = kPlenty,
          .triangles = std::make_shared<const TriMesh>(mesh)};
}

LookOrder texturedBox() {
  LookOrder order = orderFor(makeBox({kSide_m, kSide_m, kSide_m}, 1).value());
  order.surface.texture = Texture{.family = NoiseFamily{.wavelength_m = 0.01}, .amplitude_m = 0.0005};
  return order;
}

int hidden(const Look& look, Vec3 eye) {
  int count = 0;
  for (const Look::Side& side : look.sides) count += facesAway(look, side, eye);
  return count;
}

TEST(Look, OfATexturedBoxLeavesOutItsFarSides) {
  const Look look = makeLook(texturedBox());
  ASSERT_EQ(look.sides.size(), 6U);
  EXPECT_EQ(hidden(look, {1, 1, 1}), 3);
  EXPECT_EQ(hidden(look, {1, 0, 0}), 1);  // the sides around are seen by their bumps
  EXPECT_EQ(hidden(look, {0, 0, 0}), 0);
}

TEST(Look, OfAnOpenSurfaceIsSeenFromBothSides) {
  LookOrder order = texturedBox();
  TriMesh open = *order.triangles;
  open.triangles.pop_back();
  order.triangles = std::make_shared<const TriMesh>(open);
  EXPECT_EQ(hidden(makeLook(order), {1, 1, 1}), 0);
}

TEST(Look, HasEveryTriangleOnOneSide) {
  LookOrder order = texturedBox();
  order.surface.shading = Shading{.crease_rad = 0.5, .creases = {}};
  const Look look = makeLook(order);
  vtkIdType triangles = 0;
  for (const Look::Side& side : look.sides) {
    triangles += side.drawn->GetNumberOfPolys();
    EXPECT_EQ(side.drawn->GetPoints(), look.sides.front().drawn->GetPoints());
  }
  EXPECT_GT(triangles, 10'000);
  EXPECT_EQ(static_cast<std::size_t>(look.sides.front().drawn->GetNumberOfPoints()), look.heights.size());
  EXPECT_EQ(look.shadow->GetNumberOfPolys(), 12);
  EXPECT_FALSE(look.faceted);
}

TEST(Look, OfAPlainMeshIsFacetedAndItsOwnShadow) {
  const Look look = makeLook(orderFor(makeSphere(0.05, 8).value()));
  ASSERT_EQ(look.sides.size(), 1U);
  EXPECT_TRUE(look.faceted);
  EXPECT_EQ(look.shadow, look.sides.front().drawn);
  EXPECT_EQ(look.rims, nullptr);
  EXPECT_FALSE(facesAway(look, look.sides.front(), {1, 1, 1}));
}

TEST(Look, KnowsTheLeastAndTheMostFriction) {
  LookOrder order = orderFor(makeBox({kSide_m, kSide_m, kSide_m}, 1).value());
  order.surface.friction = Friction{.mu_static = 0.5, .mu_dynamic = 0.4, .over = PerVertexScale{}};
  order.frictionScale = std::make_shared<const std::vector<float>>(std::vector<float>{1, 1, 0, 1, 1, 2, 1, 1});
  const Look look = makeLook(order);
  EXPECT_FLOAT_EQ(look.leastFriction, 0);
  EXPECT_FLOAT_EQ(look.mostFriction, 1);
  order.frictionScale = std::make_shared<const std::vector<float>>(std::vector<float>{1, 2});  // of another mesh
  EXPECT_TRUE(makeLook(order).friction.empty());
}

}  // namespace
}  // namespace haptics
