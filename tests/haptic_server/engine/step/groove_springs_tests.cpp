#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "haptic_server/engine/step/groove_springs.h"

namespace haptics::groove_springs_tests {
namespace {

const Vec3 kA = glm::normalize(Vec3(0.2, -0.1, 1)), kB = glm::normalize(Vec3(1, 0.3, 0.4)),
           kC = glm::normalize(Vec3(-0.3, 1, 0.2));
constexpr double kStiffA = 900, kStiffB = 500, kStiffC = 700;

GrooveSprings two() {
  GrooveSprings springs;
  springs.add(kA, kStiffA);
  springs.add(kB, kStiffB);
  return springs;
}
GrooveSprings three() {
  GrooveSprings springs = two();
  springs.add(kC, kStiffC);
  return springs;
}

/// Work round a loop of penetrations, J.
template <class Penetration>
double loop_J(const GrooveSprings& springs, Penetration penetration) {
  constexpr int kSteps = 4000;
  double work_J = 0;
  for (int i = 0; i < kSteps; ++i) {
    const auto at = [&](double step) { return penetration(2 * std::numbers::pi * step / kSteps); };
    work_J += glm::dot(springs.force_N(at(i + 0.5)), at(i + 1) - at(i));
  }
  return work_J;
}

TEST(GrooveSprings, TakeNothingInALoopOfTwo) {
  const auto ellipse = [](double angle) {
    return (2 + std::cos(angle)) * 1e-3 * kA + (1.5 + std::sin(angle)) * 1e-3 * kB;
  };
  EXPECT_NEAR(loop_J(two(), ellipse), 0, 1e-10);
  const auto ownPart = [](Vec3 p) {
    const double cosine = glm::dot(kA, kB), sine2 = 1 - cosine * cosine;
    const double a = glm::dot(p, kA), b = glm::dot(p, kB);
    return kStiffA * (a - cosine * b) / sine2 * kA + kStiffB * (b - cosine * a) / sine2 * kB;
  };
  double work_J = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto at = [&](double step) { return ellipse(2 * std::numbers::pi * step / 4000); };
    work_J += glm::dot(ownPart(at(i + 0.5)), at(i + 1) - at(i));
  }
  EXPECT_GT(std::abs(work_J), 1e-4) << "the loop does not show what each spring with its own part would give";
}

TEST(GrooveSprings, TakeNothingInALoopOfThree) {
  const auto loop = [](double angle) {
    return (2 + std::cos(angle)) * 1e-3 * kA + (1.5 + std::sin(angle)) * 1e-3 * kB +
           (1.2 + 0.6 * std::cos(2 * angle + 1)) * 1e-3 * kC;
  };
  EXPECT_NEAR(loop_J(three(), loop), 0, 1e-8);
}

TEST(GrooveSprings, GoOverFromOneSurfaceToTwoAndThreeWithoutAStep) {
  constexpr double kLittle_m = 1e-9, kFew_N = 1e-4;
  const Vec3 alone = 2e-3 * kA, both = alone + 1e-3 * kB;
  EXPECT_LT(glm::distance(two().force_N(alone + kLittle_m * kB), kStiffA * alone), kFew_N);
  EXPECT_LT(glm::distance(two().force_N(2e-3 * kB + kLittle_m * kA), kStiffB * 2e-3 * kB), kFew_N);
  EXPECT_LT(glm::distance(three().force_N(both + kLittle_m * kC), two().force_N(both)), kFew_N);
  EXPECT_LT(glm::distance(three().force_N(alone + kLittle_m * (kB + kC)), kStiffA * alone), kFew_N);
}

TEST(GrooveSprings, HaveEachItsOwnPartAtRightAngles) {
  GrooveSprings springs;
  springs.add({0, 0, 1}, kStiffA);
  springs.add({0, 1, 0}, kStiffB);
  const Vec3 force_N = springs.force_N({0, 1e-3, 2e-3});
  EXPECT_LT(glm::distance(force_N, Vec3(0, kStiffB * 1e-3, kStiffA * 2e-3)), 1e-12);
}

TEST(GrooveSprings, AreOneSpringWhereTheyAreAsStiff) {
  GrooveSprings springs;
  springs.add(kA, kStiffA);
  springs.add(kB, kStiffA);
  springs.add(kC, kStiffA);
  const Vec3 p = 1e-3 * kA + 2e-3 * kB + 0.5e-3 * kC;
  EXPECT_EQ(springs.force_N(p), kStiffA * p);
}

TEST(GrooveSprings, OfWhichTwoAreAsOneKeepTheThird) {
  const Vec3 normals[] = {kA, kA, kB};
  const double stiffnesses[] = {kStiffA, kStiffA, kStiffB};
  for (const std::size_t last : {0U, 1U, 2U}) {  // the one that is apart
    GrooveSprings springs;
    for (std::size_t i = 1; i <= 3; ++i) springs.add(normals[(last + i) % 3], stiffnesses[(last + i) % 3]);
    EXPECT_LT(glm::distance(springs.force_N(1e-3 * kB), kStiffB * 1e-3 * kB), 1e-9) << last;
    EXPECT_LT(glm::distance(springs.force_N(1e-3 * kA), kStiffA * 1e-3 * kA), 1e-9) << last;
  }
}

TEST(GrooveSprings, DoNotShakeTheDeviceWhereTheyAreNearlyOnePlane) {
  for (const double apart : {0.5, 0.1, 0.02}) {
    const Vec3 first(0, 0, 1), second(std::sin(apart), 0, std::cos(apart));
    GrooveSprings springs;
    springs.add(first, kStiffA);
    springs.add(second, kStiffB);
    const Vec3 p = 1e-3 * first + 1e-3 * second;
    const Vec3 aside = glm::normalize(second - first);
    constexpr double kStep_m = 1e-9;
    const Vec3 change_N = springs.force_N(p + kStep_m * aside) - springs.force_N(p - kStep_m * aside);
    const double lateral_N_per_m = std::abs(glm::dot(change_N, aside)) / (2 * kStep_m);
    EXPECT_LT(lateral_N_per_m, 5.1 * (kStiffA - kStiffB) + kStiffA) << apart << " rad apart";
  }
}

}  // namespace
}  // namespace haptics::groove_springs_tests
