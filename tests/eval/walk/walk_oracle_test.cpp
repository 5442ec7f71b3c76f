#include "tests/eval/walk/walk_oracle.h"

#include <gtest/gtest.h>

#include "tests/eval/walk/cracked_block.h"

namespace haptics::eval::walk_oracle_test {
namespace {

constexpr double kStep_m = 7e-6;

TEST(WalkOracle, TakesTheTipOfACrackForALocalMinimumThoughItsWallsStandBackToBack) {
  const CrackedBlock block;
  ASSERT_TRUE(block.soup.isInside({0, 0, -0.01}, 0));
  ASSERT_FALSE(block.soup.isInside({0, 0, -0.000001}, 0));
  for (const Vec3 hip : {Vec3(0, 0, -0.006), Vec3(0.001, 0.002, -0.006), Vec3(0.004, -0.003, -0.004)}) {
    EXPECT_TRUE(WalkOracle(block.soup).isLocalMinimum(Vec3(Vec3f(CrackedBlock::kTip)), hip, kStep_m));
  }
}

TEST(WalkOracle, TellsAPlaceFromWhichAWayLeadsNearer) {
  const CrackedBlock block;
  EXPECT_TRUE(WalkOracle(block.soup).isLocalMinimum({0.02, 0.01, 0}, {0.02, 0.01, -0.005}, kStep_m));
  EXPECT_FALSE(WalkOracle(block.soup).isLocalMinimum({0.02, 0.01, 0}, {0.024, 0.01, -0.005}, kStep_m));
}

TEST(WalkOracle, TakesAPlaceForALocalMinimumRightToWhereItEnds) {
  const CrackedBlock block;
  WalkOracle judge(block.soup);
  const double edge = 0.1F;
  for (const double before_m : {1e-12, 1e-9, 1e-7}) {
    const Vec3 hip(edge - before_m, 0.01, -0.005);
    EXPECT_TRUE(judge.isLocalMinimum({edge - before_m, 0.01, 0}, hip, kStep_m)) << before_m;
    EXPECT_FALSE(judge.isLocalMinimum({edge, 0.01, 0}, hip, kStep_m)) << before_m;
  }
}

TEST(WalkOracle, TakesAnIhipForHeldByATriangleThatItIsPushedAlongAtAGraze) {
  const CrackedBlock block;
  WalkOracle judge(block.soup);
  EXPECT_FALSE(judge.isHeldByNothing({0.02, 0.01, 2e-7}, {0.021, 0.01, -12e-6}));
  EXPECT_TRUE(judge.isHeldByNothing({0.02, 0.01, 2e-7}, {0.021, 0.01, 12e-6}));
  EXPECT_TRUE(judge.isHeldByNothing({0.02, 0.01, 2e-6}, {0.021, 0.01, -12e-6}));
}

}  // namespace
}  // namespace haptics::eval::walk_oracle_test
