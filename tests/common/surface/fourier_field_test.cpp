#include "common/surface/fourier_field.h"

#include <gtest/gtest.h>

#include <numbers>

#include "field_checks.h"

namespace haptics::fourier_field_test {
namespace {

using namespace fixture;
using std::numbers::pi;

constexpr double kWavelength_m = 0.002;
const Vec3 kAlongX(1, 0, 0);

Vec3 turnedBy(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad), 0}; }

FourierFamily several() {
  return {{{1, kAlongX, kWavelength_m, 0.3},
           {0.5, turnedBy(1), kWavelength_m / 2, 1},
           {-0.7, glm::normalize(Vec3(1, 2, 3)), 1.7 * kWavelength_m, -2}}};
}

/// Never passed by a sum's values at random places, nor left by more than the part of the amplitudes.
void expectTightRange(const FourierFamily& family, double lowest, double highest, double part = 0.01) {
  const FourierField field(family);
  double sum = 0;
  for (const FourierTerm& term : family.terms) sum += std::abs(term.amplitude);
  EXPECT_LE(field.lowest(), lowest + 1e-9);
  EXPECT_GE(field.lowest(), lowest - part * sum);
  EXPECT_GE(field.highest(), highest - 1e-9);
  EXPECT_LE(field.highest(), highest + part * sum);
  expectToStayWithinBounds(field, 10 * kWavelength_m);
}

TEST(FourierField, OfOneTermIsAGrating) {
  const FourierField field({{{2, Vec3(0, 1, 0), kWavelength_m, 0.25 * pi}}});
  EXPECT_DOUBLE_EQ(field.at({5, 0, 7}).value, 2 * std::cos(0.25 * pi));
  EXPECT_NEAR(field.at({0, 0.375 * kWavelength_m, 0}).value, -2, 1e-12);
  EXPECT_NEAR(field.at({0, 0.125 * kWavelength_m, 0}).gradient.y, -2 * 2 * pi / kWavelength_m, 1e-9);
  EXPECT_DOUBLE_EQ(field.shortestWavelength_m(), kWavelength_m);
}

TEST(FourierField, HasTheGradientOfItsValue) {
  expectTheGradientIsTheDerivative(FourierField(several()), 10 * kWavelength_m);
}

TEST(FourierField, HasNoStepOfValueOrGradient) {
  expectNoStepOfValueOrGradient(FourierField(several()), 10 * kWavelength_m);
}

TEST(FourierField, OfOneTermReachesItsAmplitudeExactly) {
  const FourierField field({{{-3, turnedBy(0.7), kWavelength_m, 1.1}}});
  EXPECT_DOUBLE_EQ(field.lowest(), -3);
  EXPECT_DOUBLE_EQ(field.highest(), 3);
}

TEST(FourierField, OfWavesInThreeDirectionsReachesAllTheirAmplitudes) { expectTightRange(several(), -2.2, 2.2); }

TEST(FourierField, OfAWaveAndItsOctaveHasTheRangeOfBothTogether) {
  expectTightRange({{{1, kAlongX, kWavelength_m, 0}, {1, kAlongX, kWavelength_m / 2, 0}}}, -1.125, 2);
}

TEST(FourierField, OfWavesAsTwoToThreeHasTheRangeOfBothTogether) {
  expectTightRange({{{1, kAlongX, kWavelength_m / 2, 0}, {1, kAlongX, -kWavelength_m / 3, 0}}}, -1.6312, 2);
}

TEST(FourierField, OfThreeWavesAt120DegreesReaches3AndMinusOneAndAHalf) {
  FourierFamily hexagons;
  for (int i = 0; i < 3; ++i) hexagons.terms.push_back({1, turnedBy(2 * pi * i / 3), kWavelength_m, 0});
  expectTightRange(hexagons, -1.5, 3);
}

TEST(FourierField, OfManyUnrelatedWavesHasTheSumOfTheirAmplitudesForABound) {
  FourierFamily family;
  Random random(3);
  for (int i = 0; i < 64; ++i) {
    family.terms.push_back({1, randomDirection(random), kWavelength_m * (1 + random.uniform()), 6 * random.uniform()});
  }
  const FourierField field(family);
  EXPECT_DOUBLE_EQ(field.highest(), 64);
  EXPECT_DOUBLE_EQ(field.lowest(), -64);
}

TEST(FourierField, WithWavelengthsAMillionTimesApartIsBoundedAllTheSame) {
  const FourierField field({{{1, kAlongX, 1, 0}, {1, kAlongX, 1e-6, 0}, {1, Vec3(0, 1, 0), 3, 0}}});
  EXPECT_NEAR(field.highest(), 3, 0.02);
  EXPECT_NEAR(field.lowest(), -3, 0.02);
}

TEST(ShapeAround, GivesSlopeAndCurvatureAcrossAGrating) {
  const Vec3 normal = glm::normalize(Vec3(0.2, 0.3, 1));
  const Vec3 across = glm::normalize(glm::cross(normal, Vec3(0, 1, 0)));
  const FourierField field({{{1, across, kWavelength_m, 0}}});
  const double k = 2 * pi / kWavelength_m;
  const double s = 0.1 * kWavelength_m;
  const FieldShape shape = shapeAround(field, s * across, normal);
  EXPECT_NEAR(shape.value, std::cos(k * s), 1e-12);
  EXPECT_NEAR(glm::length(shape.slope), k * std::sin(k * s), 1e-6 * k);
  EXPECT_NEAR(shape.curvature[0][0] + shape.curvature[1][1], -k * k * std::cos(k * s), 1e-6 * k * k);
  EXPECT_NEAR(glm::determinant(shape.curvature), 0, 1e-6 * k * k * k * k);
}

}  // namespace
}  // namespace haptics::fourier_field_test
