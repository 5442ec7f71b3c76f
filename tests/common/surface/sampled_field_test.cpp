#include "common/surface/sampled_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/surface/lattice.h"

namespace haptics::sampled_field_test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

SampledField randomField(std::uint32_t width, std::uint32_t height) {
  Random random(17);
  std::vector<float> samples(std::size_t{width} * height);
  for (float& sample : samples) sample = static_cast<float>(random.uniform());
  return SampledField::make(width, height, samples).value();
}

TEST(SampledField, PassesThroughItsSamples) {
  for (const auto& [width, height] : {std::pair(7U, 12U), std::pair(2U, 2U), std::pair(64U, 3U)}) {
    const SampledField field = randomField(width, height);
    double mean = 0;
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        const double sample = field.samples()[y * width + x];
        EXPECT_NEAR(field.at(x, y).value, sample, 1e-6);
        mean += sample / (width * height);
      }
    }
    EXPECT_NEAR(field.mean(), mean, 1e-12);
  }
}

TEST(SampledField, HasTheGradientOfItsValue) {
  const SampledField field = randomField(9, 5);
  Random random(1);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 5000; ++i) {
    const double x = 9 * random.uniform(), y = 5 * random.uniform();
    const auto [value, gradient] = field.at(x, y);
    EXPECT_NEAR(gradient.x, (field.at(x + kStep, y).value - field.at(x - kStep, y).value) / (2 * kStep), 1e-6);
    EXPECT_NEAR(gradient.y, (field.at(x, y + kStep).value - field.at(x, y - kStep).value) / (2 * kStep), 1e-6);
  }
}

TEST(SampledField, RepeatsAfterEachPeriod) {
  const SampledField field = randomField(9, 5);
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double x = 9 * random.uniform(), y = 5 * random.uniform();
    const auto here = field.at(x, y), away = field.at(x - 9 * 1000, y + 5 * 77);
    EXPECT_NEAR(here.value, away.value, 1e-9);
    EXPECT_NEAR(glm::length(here.gradient - away.gradient), 0, 1e-9);
  }
}

TEST(SampledField, IsItsFirstSampleAHairBeforeIt) {
  const SampledField field = randomField(9, 5);  // 9 - 1e-18 is 9, which is a column too far
  EXPECT_NEAR(field.at(-1e-18, -1e-18).value, field.samples()[0], 1e-6);
}

TEST(SampledField, GoesOverItsBordersWithoutAStepOfValueGradientOrCurvature) {
  const SampledField field = randomField(9, 5);
  constexpr double kStep = 1e-7;
  for (const double x : {-9.0, 0.0, 4.0, 8.0, 9.0}) {
    for (const double y : {-5.0, 0.3, 5.0, 1e6}) {
      const auto before = field.at(x - kStep, y - kStep), after = field.at(x + kStep, y + kStep);
      EXPECT_NEAR(before.value, after.value, 1e-5);
      EXPECT_NEAR(glm::length(before.gradient - after.gradient), 0, 1e-5);
    }
  }
}

TEST(SampledField, KeepsAGratingOfEightSamplesWithinHalfAPercent) {
  std::vector<float> samples;
  for (int i = 0; i < 16 * 2; ++i) samples.push_back(static_cast<float>(std::cos(2 * pi * (i % 16) / 8)));
  const SampledField field = SampledField::make(16, 2, samples).value();
  for (double x = 0; x < 16; x += 0.01) {
    EXPECT_NEAR(field.at(x, 0.3).value, std::cos(2 * pi * x / 8), 0.005);
    EXPECT_NEAR(field.at(x, 0.3).gradient.x, -2 * pi / 8 * std::sin(2 * pi * x / 8), 0.01);
  }
}

TEST(SampledField, NeverLeavesItsBoundsAndComesNearToThem) {
  for (const auto& [width, height] : {std::pair(2U, 2U), std::pair(9U, 5U), std::pair(40U, 31U)}) {
    const SampledField field = randomField(width, height);
    double lowest = 1e9, highest = -1e9, slope = 0;
    for (int i = 0; i < 50 * static_cast<int>(width); ++i) {
      for (int j = 0; j < 50 * static_cast<int>(height); ++j) {
        const auto sample = field.at(i / 50.0, j / 50.0);
        lowest = std::min(lowest, sample.value);
        highest = std::max(highest, sample.value);
        slope = std::max(slope, glm::length(sample.gradient));
      }
    }
    const SplineBounds& bounds = field.bounds();
    const double range = highest - lowest;
    EXPECT_LE(bounds.lowest, lowest);
    EXPECT_GE(bounds.lowest, lowest - 0.01 * range);
    EXPECT_GE(bounds.highest, highest);
    EXPECT_LE(bounds.highest, highest + 0.01 * range);
    EXPECT_NEAR(bounds.slope, slope, 0.15 * slope);
  }
}

TEST(SampledField, OfOneValueIsFlat) {
  const SampledField field = SampledField::make(3, 4, std::vector<float>(12, 0.25F)).value();
  EXPECT_NEAR(field.at(1.7, 2.2).value, 0.25, 1e-7);
  EXPECT_NEAR(field.bounds().lowest, 0.25, 1e-6);
  EXPECT_NEAR(field.bounds().highest, 0.25, 1e-6);
  EXPECT_NEAR(field.bounds().slope, 0, 1e-6);
}

TEST(SampledField, IsRefusedWithSidesOrValuesThatCannotBe) {
  const auto field = [](std::uint32_t width, std::uint32_t height, std::size_t count, float value = 0) {
    const auto made = SampledField::make(width, height, std::vector<float>(count, value));
    return made ? "accepted" : made.error().field;
  };
  EXPECT_EQ(field(2, 2, 4), "accepted");
  EXPECT_EQ(field(1, 2, 2), "width");
  EXPECT_EQ(field(2, 4097, 2 * 4097), "height");
  EXPECT_EQ(field(2, 2, 5), "samples");
  EXPECT_EQ(field(2, 2, 4, std::numeric_limits<float>::quiet_NaN()), "samples[0]");
  EXPECT_EQ(field(2, 2, 4, std::numeric_limits<float>::infinity()), "samples[0]");
  EXPECT_EQ(field(2, 2, 4, -1001.F), "samples[0]");
  EXPECT_THAT(SampledField::make(1, 2, {}).error().reason, HasSubstr("2 to 4096"));
}

}  // namespace
}  // namespace haptics::sampled_field_test
