#include "graphics_client/viewer/look_maker.h"

#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics {
namespace {

LookOrder ball(std::uint32_t segments) {
  const TriMesh mesh = makeSphere(0.05, segments).value();
  return {.mesh = hashOf(mesh), .surface = {}, .mostTriangles = 0, .triangles = std::make_shared<const TriMesh>(mesh)};
}

TEST(LookMaker, MakesWhatIsOrdered) {
  LookMaker maker;
  const LookOrder order = ball(8);
  const auto look = maker.order(order).get();
  EXPECT_EQ(look->triangles, order.triangles->triangles.size());
}

TEST(LookMaker, MakesTheSameOnceForAllWhoAsk) {
  LookMaker maker;
  const LookOrder order = ball(8);
  LookOrder shaded = order;
  shaded.surface.shading = Shading{.crease_rad = 1, .creases = {}};
  const auto one = maker.order(order).get();  // a look is known for as long as somebody holds it
  EXPECT_EQ(one, maker.order(order).get());
  EXPECT_NE(one, maker.order(shaded).get());
}

TEST(LookMaker, ForgetsWhatNobodyShows) {
  LookMaker maker;
  std::weak_ptr<const Look> forgotten = maker.order(ball(8)).get();
  const auto kept = maker.order(ball(9)).get();
  (void)maker.order(ball(10));
  EXPECT_TRUE(forgotten.expired());
  EXPECT_EQ(maker.order(ball(9)).get(), kept);
}

TEST(LookMaker, EndsWhileOrdersWait) {
  LookMaker maker;
  for (std::uint32_t segments = 40; segments < 60; ++segments) (void)maker.order(ball(segments));
}

}  // namespace
}  // namespace haptics
