#include "graphics_client/viewer/render_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics::render_mesh_test {
namespace {

constexpr std::size_t kPlenty = 100'000;
constexpr double kSide_m = 0.05;

SurfaceRequest requestFor(const TriMesh& mesh) {
  return {
      .mesh = hashOf(mesh), .surface = {}, .maxTriangles = kPlenty, .triangles = std::make_shared<const TriMesh>(mesh)};
}

SurfaceRequest texturedBox() {
  SurfaceRequest request = requestFor(makeBox({kSide_m, kSide_m, kSide_m}, 1).value());
  request.surface.texture = Texture{.family = NoiseFamily{.wavelength_m = 0.01}, .amplitude_m = 0.0005};
  return request;
}

int hidden(const RenderMesh& renderMesh, Vec3 eye) {
  int count = 0;
  for (const RenderMesh::Piece& piece : renderMesh.pieces) count += facesAway(renderMesh, piece, eye);
  return count;
}

TEST(RenderMesh, OfATexturedBoxLeavesOutItsFarSides) {
  const RenderMesh renderMesh = buildRenderMesh(texturedBox());
  const auto pieces = static_cast<int>(renderMesh.pieces.size());
  ASSERT_GE(pieces, 6);
  EXPECT_EQ(pieces % 6, 0) << "as many of each side";
  EXPECT_EQ(hidden(renderMesh, {1, 1, 1}), pieces / 2);
  EXPECT_EQ(hidden(renderMesh, {1, 0, 0}), pieces / 6);  // the sides around are seen by their bumps
  EXPECT_EQ(hidden(renderMesh, {0, 0, 0}), 0);
}

TEST(RenderMesh, OfVeryManyTrianglesHasACoarseCopyOfTheSameShape) {
  constexpr double kRadius_m = 0.05;
  SurfaceRequest request = requestFor(makeSphere(kRadius_m, 100).value());
  request.surface.shading = Shading{.crease_rad = 1, .creases = {}};
  const RenderMesh renderMesh = buildRenderMesh(request);
  ASSERT_EQ(renderMesh.triangles, 120'000U);
  ASSERT_TRUE(renderMesh.coarse);
  EXPECT_GT(renderMesh.coarse->GetNumberOfPolys(), 10'000);
  EXPECT_LT(renderMesh.coarse->GetNumberOfPolys(), 60'000);
  for (vtkIdType i = 0; i < renderMesh.coarse->GetNumberOfPoints(); ++i) {
    const double* p = renderMesh.coarse->GetPoint(i);
    EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), kRadius_m, 1e-6);
  }
  EXPECT_FALSE(buildRenderMesh(texturedBox()).coarse);
}

TEST(RenderMesh, OfAnOpenSurfaceIsSeenFromBothSides) {
  SurfaceRequest request = texturedBox();
  TriMesh open = *request.triangles;
  open.triangles.pop_back();
  request.triangles = std::make_shared<const TriMesh>(open);
  EXPECT_EQ(hidden(buildRenderMesh(request), {1, 1, 1}), 0);
}

TEST(RenderMesh, HasEveryTriangleInOnePieceAndAShadowOfTheMesh) {
  SurfaceRequest request = texturedBox();
  request.surface.shading = Shading{.crease_rad = 0.5, .creases = {}};
  const RenderMesh renderMesh = buildRenderMesh(request);
  vtkIdType triangles = 0;
  for (const RenderMesh::Piece& piece : renderMesh.pieces) {
    triangles += piece.drawn->GetNumberOfPolys();
    EXPECT_EQ(static_cast<std::size_t>(piece.drawn->GetNumberOfPoints()), piece.patch.points.size());
    for (const std::uint32_t p : piece.patch.points) EXPECT_LT(p, renderMesh.heights.size());
  }
  EXPECT_GT(triangles, 10'000);
  EXPECT_EQ(static_cast<std::size_t>(triangles), renderMesh.triangles);
  EXPECT_EQ(renderMesh.shadow->GetNumberOfPolys(), 12);
  EXPECT_FALSE(renderMesh.faceted);
}

TEST(RenderMesh, OfAPlainMeshIsFacetedAndInOnePieceWhereItIsSmall) {
  const RenderMesh renderMesh = buildRenderMesh(requestFor(makeSphere(0.05, 8).value()));
  ASSERT_EQ(renderMesh.pieces.size(), 1U);
  EXPECT_TRUE(renderMesh.faceted);
  EXPECT_EQ(renderMesh.shadow->GetNumberOfPolys(), renderMesh.pieces.front().drawn->GetNumberOfPolys());
  EXPECT_EQ(renderMesh.rims, nullptr);
  EXPECT_FALSE(facesAway(renderMesh, renderMesh.pieces.front(), {1, 1, 1}));
}

TEST(RenderMesh, OfAFineMeshHasACoarseShadowOfTheSameOutline) {
  const RenderMesh renderMesh = buildRenderMesh(requestFor(makeSphere(0.05, 73).value()));
  EXPECT_LT(renderMesh.shadow->GetNumberOfPolys(), 20'000);
  EXPECT_GT(renderMesh.shadow->GetNumberOfPolys(), 4'000);
  std::array<double, 6> bounds;
  renderMesh.shadow->GetBounds(bounds.data());
  for (const double bound : bounds) EXPECT_NEAR(std::abs(bound), 0.05, 0.001);
  const int seen = static_cast<int>(renderMesh.pieces.size()) - hidden(renderMesh, {0.3, 0, 0});
  EXPECT_LT(seen, 0.75 * static_cast<double>(renderMesh.pieces.size()));
}

TEST(RenderMesh, KnowsTheLeastAndTheMostFriction) {
  SurfaceRequest request = requestFor(makeBox({kSide_m, kSide_m, kSide_m}, 1).value());
  request.surface.friction = Friction{.mu_static = 0.5, .mu_dynamic = 0.4, .over = PerVertexScale{}};
  request.frictionScale = std::make_shared<const std::vector<float>>(std::vector<float>{1, 1, 0, 1, 1, 2, 1, 1});
  const RenderMesh renderMesh = buildRenderMesh(request);
  EXPECT_FLOAT_EQ(renderMesh.minFriction, 0);
  EXPECT_FLOAT_EQ(renderMesh.maxFriction, 1);
  request.frictionScale = std::make_shared<const std::vector<float>>(std::vector<float>{1, 2});  // of another mesh
  EXPECT_TRUE(buildRenderMesh(request).friction.empty());
}

}  // namespace
}  // namespace haptics::render_mesh_test
