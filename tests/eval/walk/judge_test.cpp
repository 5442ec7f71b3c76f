#include "tests/eval/walk/judge.h"

#include <gtest/gtest.h>

namespace haptics::eval {
namespace {

constexpr double kStep_m = 7e-6;

/// A block with a crack of 20 um by 1 um in its top that narrows to a point 14 um down.
struct CrackedBlock {
  static constexpr Vec3 kTip{0.000003, 0, -0.000014};
  TriangleSoup soup;

  CrackedBlock() {
    const float out = 0.1F;
    std::vector<Vec3f> vertices;
    for (const auto& [half, y, z] : {std::array{out, out, 0.0F}, {0.00001F, 0.0000005F, 0.0F}, {out, out, -out}}) {
      for (const Vec3f corner : {Vec3f(-half, -y, z), Vec3f(half, -y, z), Vec3f(half, y, z), Vec3f(-half, y, z)}) {
        vertices.push_back(corner);
      }
    }
    vertices.push_back(Vec3f(kTip));
    std::vector<TriangleIndices> triangles{{8, 10, 9}, {8, 11, 10}};
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t next = (k + 1) % 4;
      triangles.push_back({k, next, 4 + next});
      triangles.push_back({k, 4 + next, 4 + k});
      triangles.push_back({4 + k, 4 + next, 12});
      triangles.push_back({8 + k, 8 + next, next});
      triangles.push_back({8 + k, next, k});
    }
    soup.add(vertices, triangles, Pose{});
    soup.finish();
  }
};

TEST(Judge, TakesTheTipOfACrackForALocalMinimumThoughItsWallsStandBackToBack) {
  const CrackedBlock block;
  ASSERT_TRUE(block.soup.isInside({0, 0, -0.01}, 0));
  ASSERT_FALSE(block.soup.isInside({0, 0, -0.000001}, 0));
  for (const Vec3 hip : {Vec3(0, 0, -0.006), Vec3(0.001, 0.002, -0.006), Vec3(0.004, -0.003, -0.004)}) {
    EXPECT_TRUE(Judge(block.soup).isLocalMinimum(Vec3(Vec3f(CrackedBlock::kTip)), hip, kStep_m));
  }
}

TEST(Judge, TellsAPlaceFromWhichAWayLeadsNearer) {
  const CrackedBlock block;
  EXPECT_TRUE(Judge(block.soup).isLocalMinimum({0.02, 0.01, 0}, {0.02, 0.01, -0.005}, kStep_m));
  EXPECT_FALSE(Judge(block.soup).isLocalMinimum({0.02, 0.01, 0}, {0.024, 0.01, -0.005}, kStep_m));
}

TEST(Judge, TakesAnIhipForHeldByATriangleThatItIsPushedAlongAtAGraze) {
  const CrackedBlock block;
  Judge judge(block.soup);
  EXPECT_FALSE(judge.isHeldByNothing({0.02, 0.01, 2e-7}, {0.021, 0.01, -12e-6}));
  EXPECT_TRUE(judge.isHeldByNothing({0.02, 0.01, 2e-7}, {0.021, 0.01, 12e-6}));
  EXPECT_TRUE(judge.isHeldByNothing({0.02, 0.01, 2e-6}, {0.021, 0.01, -12e-6}));
}

}  // namespace
}  // namespace haptics::eval
