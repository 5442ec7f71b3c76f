#include "graphics_client/viewer/render_mesh_builder.h"

#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics::render_mesh_builder_test {
namespace {

SurfaceRequest ball(std::uint32_t segments) {
  const TriMesh mesh = makeSphere(0.05, segments).value();
  return {.mesh = hashOf(mesh), .surface = {}, .maxTriangles = 0, .triangles = std::make_shared<const TriMesh>(mesh)};
}

TEST(RenderMeshBuilder, MakesWhatIsOrdered) {
  RenderMeshBuilder builder;
  const SurfaceRequest request = ball(8);
  const auto renderMesh = builder.request(request).get();
  EXPECT_EQ(renderMesh->triangles, request.triangles->triangles.size());
}

TEST(RenderMeshBuilder, MakesTheSameOnceForAllWhoAsk) {
  RenderMeshBuilder builder;
  const SurfaceRequest request = ball(8);
  SurfaceRequest shaded = request;
  shaded.surface.shading = Shading{.crease_rad = 1, .creases = {}};
  const auto one = builder.request(request).get();  // a mesh is cached for as long as it is in use
  EXPECT_EQ(one, builder.request(request).get());
  EXPECT_NE(one, builder.request(shaded).get());
}

TEST(RenderMeshBuilder, ForgetsWhatNobodyShows) {
  RenderMeshBuilder builder;
  std::weak_ptr<const RenderMesh> forgotten = builder.request(ball(8)).get();
  const auto kept = builder.request(ball(9)).get();
  (void)builder.request(ball(10));
  EXPECT_TRUE(forgotten.expired());
  EXPECT_EQ(builder.request(ball(9)).get(), kept);
}

TEST(RenderMeshBuilder, EndsWhileOrdersWait) {
  RenderMeshBuilder builder;
  for (std::uint32_t segments = 40; segments < 60; ++segments) (void)builder.request(ball(segments));
}

}  // namespace
}  // namespace haptics::render_mesh_builder_test
