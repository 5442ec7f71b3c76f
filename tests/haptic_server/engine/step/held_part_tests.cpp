#include <gtest/gtest.h>

#include "haptic_server/engine/step/held_springs.h"

namespace haptics::held_part_tests {
namespace {

const Vec3 kA = glm::normalize(Vec3(0.2, -0.1, 1)), kB = glm::normalize(Vec3(1, 0.3, 0.4)),
           kC = glm::normalize(Vec3(-0.3, 1, 0.2));

TEST(HeldPart, IsThePartOfEachOfTwoSurfaces) {
  const Vec3 vector = 2e-3 * kA + 5e-4 * kB;
  EXPECT_NEAR(heldPart(vector, kA, kB, Vec3(0)), 2e-3, 1e-15);
  EXPECT_NEAR(heldPart(vector, kB, kA, Vec3(0)), 5e-4, 1e-15);
}

TEST(HeldPart, IsThePartOfEachOfThreeSurfaces) {
  const Vec3 vector = 2e-3 * kA + 5e-4 * kB + 1e-3 * kC;
  EXPECT_NEAR(heldPart(vector, kA, kB, kC), 2e-3, 1e-15);
  EXPECT_NEAR(heldPart(vector, kB, kC, kA), 5e-4, 1e-15);
  EXPECT_NEAR(heldPart(vector, kC, kA, kB), 1e-3, 1e-15);
}

TEST(HeldPart, IsAllWhereTheNormalsAreTheSame) { EXPECT_NEAR(heldPart(2e-3 * kA, kA, kA, Vec3(0)), 2e-3, 1e-15); }

}  // namespace
}  // namespace haptics::held_part_tests
