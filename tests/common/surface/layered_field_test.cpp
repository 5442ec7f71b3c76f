#include "common/surface/layered_field.h"

#include <gtest/gtest.h>

#include "common/surface/make_field.h"
#include "field_checks.h"

namespace haptics::layered_field_test {
namespace {

using namespace fixture;
using Combination = LayeredFamily::Combination;

constexpr double kWavelength_m = 0.004;

FourierFamily wave(Vec3 direction, double wavelength_m, double phase_rad = 0) {
  return {{{1, direction, wavelength_m, phase_rad}}};
}

std::shared_ptr<const ScalarField> made(const FieldFamily& family) {
  return makeField(family, [](const ContentHash&) { return nullptr; }).value();
}

/// A wave, noise on it and cells, the wave upside down.
LayeredFamily three(Combination combination) {
  return {combination,
          {{-1.5, wave({1, 0, 0}, kWavelength_m, 0.4)},
           {0.5, NoiseFamily{.wavelength_m = kWavelength_m / 2, .octaves = 2}},
           {2, CellularFamily{.cell_m = kWavelength_m}}}};
}

class Layers : public ::testing::TestWithParam<Combination> {};

INSTANTIATE_TEST_SUITE_P(LayeredField, Layers, ::testing::Values(Combination::kSum, Combination::kProduct));

TEST_P(Layers, HaveTheSumOrTheProductOfTheirValues) {
  const LayeredFamily family = three(GetParam());
  const auto field = made(family);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point = randomPoint(random, 10 * kWavelength_m);
    double sum = 0, product = 1;
    for (const auto& [weight, layer] : family.layers) {
      const double value = weight * made(layer)->at(point).value;
      sum += value;
      product *= value;
    }
    EXPECT_DOUBLE_EQ(field->at(point).value, GetParam() == Combination::kSum ? sum : product);
  }
}

TEST_P(Layers, HaveTheGradientOfTheirValue) {
  expectTheGradientIsTheDerivative(*made(three(GetParam())), 10 * kWavelength_m);
}

TEST_P(Layers, HaveNoStepOfValueOrGradient) {
  expectNoStepOfValueOrGradient(*made(three(GetParam())), 10 * kWavelength_m, 10);
}

TEST_P(Layers, StayWithinTheirBounds) { expectToStayWithinBounds(*made(three(GetParam())), 10 * kWavelength_m); }

TEST(LayeredField, OfIndependentLayersReachesItsBounds) {
  const Vec3 x(1, 0, 0), y(0, 1, 0);
  const auto field = [&](Combination combination) {
    return made(LayeredFamily{combination, {{2, wave(x, kWavelength_m)}, {-3, wave(y, kWavelength_m)}}});
  };
  const Vec3 trough(0.5 * kWavelength_m, 0, 0);
  EXPECT_DOUBLE_EQ(field(Combination::kSum)->lowest(), -5);
  EXPECT_DOUBLE_EQ(field(Combination::kSum)->highest(), 5);
  EXPECT_DOUBLE_EQ(field(Combination::kSum)->at(trough).value, -5);
  EXPECT_DOUBLE_EQ(field(Combination::kProduct)->lowest(), -6);
  EXPECT_DOUBLE_EQ(field(Combination::kProduct)->highest(), 6);
  EXPECT_DOUBLE_EQ(field(Combination::kProduct)->at(trough).value, 6);
}

TEST(LayeredField, OfLayersThatDoNotChangeSignHasTheProductOfTheirRanges) {
  const auto cells = [](std::uint32_t seed) { return CellularFamily{.cell_m = kWavelength_m, .seed = seed}; };
  const auto own = made(cells(1)), other = made(cells(2));
  ASSERT_GE(own->lowest(), 0);
  const auto product = made(LayeredFamily{Combination::kProduct, {{1, cells(1)}, {-2, cells(2)}}});
  EXPECT_DOUBLE_EQ(product->lowest(), -2 * own->highest() * other->highest());
  EXPECT_DOUBLE_EQ(product->highest(), -2 * own->lowest() * other->lowest());
}

TEST(LayeredField, HasTheFinestDetailOfASumOrAProductOfWaves) {
  const Vec3 x(1, 0, 0);
  const auto field = [&](Combination combination) {
    return made(LayeredFamily{combination, {{1, wave(x, kWavelength_m)}, {1, wave(x, kWavelength_m / 3)}}});
  };
  EXPECT_DOUBLE_EQ(field(Combination::kSum)->shortestWavelength_m(), kWavelength_m / 3);
  // cos(q x) cos(3 q x) = cos(2 q x) / 2 + cos(4 q x) / 2
  EXPECT_DOUBLE_EQ(field(Combination::kProduct)->shortestWavelength_m(), kWavelength_m / 4);
}

TEST(LayeredField, NamesTheLayerWhoseSampledFieldIsNotThere) {
  const FieldLookup none = [](const ContentHash&) { return nullptr; };
  const auto missing =
      makeField(LayeredFamily{Combination::kSum, {{1, GrainFamily{0.001}}, {1, MappedFamily{}}}}, none);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().field, "layers.layer[1].field.field");
}

}  // namespace
}  // namespace haptics::layered_field_test
