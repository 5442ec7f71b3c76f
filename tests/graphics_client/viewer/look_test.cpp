#include "graphics_client/viewer/look.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

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
  for (const Look::Piece& piece : look.pieces) count += facesAway(look, piece, eye);
  return count;
}

TEST(Look, OfATexturedBoxLeavesOutItsFarSides) {
  const Look look = makeLook(texturedBox());
  const auto pieces = static_cast<int>(look.pieces.size());
  ASSERT_GE(pieces, 6);
  EXPECT_EQ(pieces % 6, 0) << "as many of each side";
  EXPECT_EQ(hidden(look, {1, 1, 1}), pieces / 2);
  EXPECT_EQ(hidden(look, {1, 0, 0}), pieces / 6);  // the sides around are seen by their bumps
  EXPECT_EQ(hidden(look, {0, 0, 0}), 0);
}

TEST(Look, OfAnOpenSurfaceIsSeenFromBothSides) {
  LookOrder order = texturedBox();
  TriMesh open = *order.triangles;
  open.triangles.pop_back();
  order.triangles = std::make_shared<const TriMesh>(open);
  EXPECT_EQ(hidden(makeLook(order), {1, 1, 1}), 0);
}

TEST(Look, HasEveryTriangleInOnePieceAndAShadowOfTheMesh) {
  LookOrder order = texturedBox();
  order.surface.shading = Shading{.crease_rad = 0.5, .creases = {}};
  const Look look = makeLook(order);
  vtkIdType triangles = 0;
  for (const Look::Piece& piece : look.pieces) {
    triangles += piece.drawn->GetNumberOfPolys();
    EXPECT_EQ(static_cast<std::size_t>(piece.drawn->GetNumberOfPoints()), piece.patch.points.size());
    for (const std::uint32_t p : piece.patch.points) EXPECT_LT(p, look.heights.size());
  }
  EXPECT_GT(triangles, 10'000);
  EXPECT_EQ(static_cast<std::size_t>(triangles), look.triangles);
  EXPECT_EQ(look.shadow->GetNumberOfPolys(), 12);
  EXPECT_FALSE(look.faceted);
}

TEST(Look, OfAPlainMeshIsFacetedAndInOnePieceWhereItIsSmall) {
  const Look look = makeLook(orderFor(makeSphere(0.05, 8).value()));
  ASSERT_EQ(look.pieces.size(), 1U);
  EXPECT_TRUE(look.faceted);
  EXPECT_EQ(look.shadow->GetNumberOfPolys(), look.pieces.front().drawn->GetNumberOfPolys());
  EXPECT_EQ(look.rims, nullptr);
  EXPECT_FALSE(facesAway(look, look.pieces.front(), {1, 1, 1}));
}

TEST(Look, OfAFineMeshHasACoarseShadowOfTheSameOutline) {
  const Look look = makeLook(orderFor(makeSphere(0.05, 73).value()));
  EXPECT_LT(look.shadow->GetNumberOfPolys(), 20'000);
  EXPECT_GT(look.shadow->GetNumberOfPolys(), 4'000);
  std::array<double, 6> bounds;
  look.shadow->GetBounds(bounds.data());
  for (const double bound : bounds) EXPECT_NEAR(std::abs(bound), 0.05, 0.001);
  const int seen = static_cast<int>(look.pieces.size()) - hidden(look, {0.3, 0, 0});
  EXPECT_LT(seen, 0.75 * static_cast<double>(look.pieces.size()));
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
