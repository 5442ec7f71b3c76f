#include "tests/eval/walk/reference_proxy.h"

#include <gtest/gtest.h>

#include "tests/eval/random.h"
#include "tests/eval/walk/cracked_block.h"
#include "tests/haptic_server/geometry/shapes.h"

namespace haptics::eval {
namespace {

TEST(ReferenceProxy, GoesOnFromTheTipOfACrackOutsideOfTheBody) {
  const CrackedBlock block;
  const Vec3 tip(Vec3f(CrackedBlock::kTip));
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 hip = tip + Vec3(0, 0, -0.006) + random.direction() * 0.004;
    ReferenceProxy reference(block.soup);
    reference.resume(tip + random.direction() * 1e-12, hip);
    EXPECT_LT(glm::distance(reference.ihip(), tip), 1e-6) << "HIP at " << hip.x << ' ' << hip.y << ' ' << hip.z;
  }
}

TEST(ReferenceProxy, LeapsOnlyWhereAMinimumEnds) {
  const shapes::Shape cube = shapes::box({0.1, 0.1, 0.1});
  TriangleSoup soup;
  soup.add(cube.vertices, cube.triangles, Pose{});
  soup.finish();
  ReferenceProxy reference(soup);
  reference.place({0, 0, 0.06});
  reference.follow({0, 0, 0.03}, 64);
  EXPECT_LT(reference.leap_m(), 1e-9);
  reference.follow({0.025, 0, 0.03}, 64);
  EXPECT_LT(reference.leap_m(), 1e-9);
  reference.follow({0.06, 0, 0.03}, 64);  // over the edge, from where the side leads to the HIP
  EXPECT_NEAR(reference.leap_m(), 0.02, 1e-3);
}

}  // namespace
}  // namespace haptics::eval
