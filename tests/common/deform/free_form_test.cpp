#include "common/deform/free_form.h"

#include <gtest/gtest.h>

#include <random>

#include "common/deform/triangle_map.h"

namespace haptics::free_form_test {
namespace {

constexpr Vec3 kLow(-0.01, 0.02, 0);
constexpr Vec3 kSize(0.02, 0.04, 0.1);

TEST(FreeForm, ChangesNothingAtRest) {
  for (const std::array<std::uint32_t, 3> points : {std::array<std::uint32_t, 3>{2, 2, 2}, {3, 4, 8}}) {
    const std::vector<Vec3f> control = FreeForm::atRest(kLow, kSize, points);
    const FreeForm form(kLow, kSize, points, control);
    for (const Vec3 part : {Vec3(0), Vec3(1), Vec3(0.3, 0.5, 0.9)}) {
      const Vec3f rest(kLow + part * kSize);
      EXPECT_LT(glm::length(Vec3(form(rest)) - Vec3(rest)), 1e-8);
    }
  }
}

/// Fields are asked at such places, and such gradients become forces.
TEST(TriangleMap, StaysWithinBoundsOnTrianglesThatCollapse) {
  std::mt19937_64 random{3};
  std::uniform_real_distribution<double> part(-1, 1), power(-45, 3);
  const auto place = [&](Vec3 scale) { return scale * Vec3(part(random), part(random), part(random)); };
  for (int i = 0; i < 100'000; ++i) {
    const TriangleMap::Corners rest{place(Vec3(0.1)), place(Vec3(0.1)), place(Vec3(0.1))};
    Vec3 scale(std::pow(10, power(random)), std::pow(10, power(random)), std::pow(10, power(random)));
    if (i % 2 == 0) scale = Vec3(scale.x);
    const Vec3 at = place(Vec3(0.1));
    TriangleMap::Corners now;
    for (std::size_t k = 0; k < 3; ++k) now[k] = Vec3(Vec3f(scale * rest[k]));
    if (i % 5 == 0) now[2] = now[1];
    const TriangleMap map(now, rest);
    ASSERT_LT(glm::length(map.place(at)), 1e6) << i;
    ASSERT_LT(glm::length(map.gradient(Vec3(1e4, 2e4, -1e4))), 1e20) << i;
  }
}

TEST(FreeForm, IsBernsteinsPolynomialInEachDirection) {
  const std::array<std::uint32_t, 3> points{4, 2, 3};
  std::vector<Vec3f> control = FreeForm::atRest(kLow, kSize, points);
  control[2 + 4 * (1 + 2 * 1)] += Vec3f(0.001F, 0, 0);  // x 2 of 0 to 3, y 1 of 0 to 1, z 1 of 0 to 2
  const FreeForm form(kLow, kSize, points, control);
  const Vec3 t(0.2, 0.7, 0.6);
  const Vec3f rest(kLow + t * kSize);
  const double weight = 3 * t.x * t.x * (1 - t.x) * t.y * 2 * t.z * (1 - t.z);
  EXPECT_NEAR(double(form(rest).x) - double(rest.x), 0.001 * weight, 1e-8);
  EXPECT_NEAR(form(rest).y, rest.y, 1e-8);
}

TEST(FreeForm, MovesEverythingWithItsControlPoints) {
  const std::array<std::uint32_t, 3> points{3, 3, 3};
  std::vector<Vec3f> control = FreeForm::atRest(kLow, kSize, points);
  for (Vec3f& point : control) point = Vec3f(-point.y, point.x, point.z) + Vec3f(0.1F, 0, 0);  // a quarter turn
  const FreeForm form(kLow, kSize, points, control);
  const Vec3f rest(kLow + Vec3(0.1, 0.2, 0.8) * kSize);
  EXPECT_LT(glm::length(Vec3(form(rest)) - Vec3(-rest.y + 0.1F, rest.x, rest.z)), 2e-8);
}

}  // namespace
}  // namespace haptics::free_form_test
