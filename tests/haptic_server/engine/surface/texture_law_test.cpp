#include "haptic_server/engine/surface/texture_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace haptics::texture_law_test {
namespace {

const Vec3 kUp(0, 0, 1);

void expectNear(Vec3 a, Vec3 b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

TEST(TextureLaw, TurnsTheNormalByThePartOfTheGradientAlongTheSurface) {
  // Eq. (2) by hand: M = (0, 0, 1) - (0.3, -0.4, 0.5) + 0.5 (0, 0, 1).
  expectNear(perturbedNormal(kUp, Vec3(0.3, -0.4, 0.5)), Vec3(-0.3, 0.4, 1), 1e-15);
}

TEST(TextureLaw, IsInContactOutsideOfTheSurfaceOnABumpAndNotWithinItInAPit) {
  EXPECT_DOUBLE_EQ(texturedDepth(0.5e-3, 0.2e-3), 0.3e-3);
  EXPECT_EQ(texturedDepth(0.5e-3, 0.6e-3), 0);
  EXPECT_DOUBLE_EQ(texturedDepth(-0.5e-3, -2e-3), 1.5e-3);
  EXPECT_EQ(texturedDepth(-0.5e-3, -0.3e-3), 0);
}

TEST(TextureLaw, GivesEquation4aByHandWhenDeepAgainstTheTexture) {
  // d = 2 mm, h = 0.5 mm, K = 2: d >= K h = 1 mm. F = (2 - 1) (0, 0, 1) + 1 (-0.6, 0.8, 1) = (-0.6, 0.8, 2) mm.
  expectNear(hoForce(2e-3, kUp, {0.5e-3, Vec3(0.6, -0.8, 0)}, 2), Vec3(-0.6e-3, 0.8e-3, 2e-3), 1e-18);
}

TEST(TextureLaw, GivesEquation4bByHandWhenShallow) {
  // d = 0.4 mm < K h = 1 mm: F = d M = 0.4 (-0.6, 0.8, 1) mm.
  expectNear(hoForce(0.4e-3, kUp, {0.5e-3, Vec3(0.6, -0.8, 0)}, 2), Vec3(-0.24e-3, 0.32e-3, 0.4e-3), 1e-18);
}

TEST(TextureLaw, IsContinuousBetweenTheTwoEquations) {
  const HeightSample relief{0.5e-3, Vec3(0.6, -0.8, 0)};
  expectNear(hoForce(0.75e-3, kUp, relief, 1.5), hoForce(std::nextafter(0.75e-3, 0), kUp, relief, 1.5), 1e-16);
}

TEST(TextureLaw, PullsUphillInAPitWhichIsWhyFieldsAreShiftedUnlessAskedNotTo) {
  EXPECT_GT(hoForce(1e-3, kUp, {-0.5e-3, Vec3(1, 0, 0)}, 1.5).x, 0);
  EXPECT_LT(hoForce(1e-3, kUp, {0.5e-3, Vec3(1, 0, 0)}, 1.5).x, 0);
}

/// A grating of 0.5 mm and 3 mm on a plane.
HeightSample grating(double x) {
  constexpr double kHalf_m = 0.25e-3, kWave = 2 * std::numbers::pi / 3e-3;
  return {kHalf_m * (1 - std::cos(kWave * x)), Vec3(kHalf_m * kWave * std::sin(kWave * x), 0, 0)};
}

/// What the force gives the hand: press at x1 from outside, slide to x2, lift.
template <class Law>
double loopWork_J(Law law, double x1, double x2, double deep_m) {
  constexpr double kStiffness = 500;
  constexpr int kSteps = 20000;
  const auto force = [&](double x, double z) {
    const HeightSample relief = grating(x);
    return kStiffness * law(texturedDepth(relief.height_m, z), kUp, relief);
  };
  double work = 0;
  const auto go = [&](double fromX, double fromZ, double toX, double toZ) {
    for (int i = 0; i < kSteps; ++i) {
      const double s = (i + 0.5) / kSteps;
      const Vec3 f = force(fromX + s * (toX - fromX), fromZ + s * (toZ - fromZ));
      work += (f.x * (toX - fromX) + f.z * (toZ - fromZ)) / kSteps;
    }
  };
  go(x1, 1e-3, x1, -deep_m);
  go(x1, -deep_m, x2, -deep_m);
  go(x2, -deep_m, x2, 1e-3);
  return work;
}

TEST(TextureLaw, DoesTheWorkOfItsFormulaInALoop) {
  constexpr double kDeep_m = 3e-3, kStiffness = 500;
  const double x1 = 0.4e-3, x2 = 1.3e-3;
  const double h1 = grating(x1).height_m, h2 = grating(x2).height_m;
  for (const double gain : {0.5, 1.0, 1.5, 2.0}) {
    const double formula = kStiffness * kDeep_m * (h2 - h1) + 0.5 * kStiffness * (1 - gain) * (h2 * h2 - h1 * h1);
    const double work =
        loopWork_J([&](double d, Vec3 n, const HeightSample& r) { return hoForce(d, n, r, gain); }, x1, x2, kDeep_m);
    EXPECT_NEAR(work, formula, 1e-4 * formula) << gain;
  }
}

TEST(TextureLaw, IsConservativeAsUnnormalisedBumpMapping) {
  EXPECT_NEAR(loopWork_J(bumpForce, 0.4e-3, 1.3e-3, 3e-3), 0, 1e-9);
}

}  // namespace
}  // namespace haptics::texture_law_test
