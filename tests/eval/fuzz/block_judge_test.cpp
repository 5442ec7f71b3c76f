#include "tests/eval/fuzz/block_judge.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

namespace haptics::eval::block_judge_test {
namespace {

Block block(Vec3 place, double mass_kg = 1, Quat turn = {1, 0, 0, 0}) {
  return {{0.03, 0.02, 0.01}, {turn, place}, mass_kg};
}

TEST(BlockJudge, TellsTheShortestWayThatPartsTwoBoxes) {
  EXPECT_NEAR(overlapOf(block(Vec3(0)), block({0.01, 0, 0.018})), 0.002, 1e-12);
  EXPECT_NEAR(overlapOf(block(Vec3(0)), block({0.061, 0, 0})), -0.001, 1e-12);
}

TEST(BlockJudge, TellsHowDeepEdgesThatCrossAre) {
  const Quat onEdge = glm::angleAxis(std::numbers::pi / 4, Vec3(1, 0, 0));
  const Block lower{{0.1, 0.01, 0.01}, {onEdge, Vec3(0)}, 0};
  const Quat across = glm::angleAxis(std::numbers::pi / 2, Vec3(0, 0, 1)) * onEdge;
  const Block upper{{0.1, 0.01, 0.01}, {across, {0, 0, 0.02 * std::numbers::sqrt2 - 0.001}}, 1};
  EXPECT_NEAR(overlapOf(lower, upper), 0.001, 1e-9);
}

TEST(BlockJudge, LetsAStackStandUntilWhatIsAboveAJointLeavesIt) {
  const auto standsWith = [](double out_m, double top_kg) {
    const std::array stack{block(Vec3(0)), block({0.02, 0, 0.02}), block({0.02 + out_m, 0, 0.04}, top_kg)};
    return stands(stack);
  };
  EXPECT_TRUE(standsWith(-0.02, 1));
  EXPECT_FALSE(standsWith(0.02, 1)) << "together they are 30 mm out, above the edge";
  EXPECT_TRUE(standsWith(0.02, 1e-3));
}

}  // namespace
}  // namespace haptics::eval::block_judge_test
