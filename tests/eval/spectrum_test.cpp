#include "tests/eval/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace haptics::eval::spectrum_test {
namespace {

constexpr double kPeriod = 1e-3;

std::vector<Vec3> tone(double frequency_Hz, int samples) {
  std::vector<Vec3> force;
  for (int i = 0; i < samples; ++i) {
    force.push_back(Vec3(0.6, 0, 0.8) * std::sin(2 * std::numbers::pi * frequency_Hz * i * kPeriod));
  }
  return force;
}

TEST(RmsAbove, IsThatOfAToneAboveAndNothingOfOneBelow) {
  for (const int samples : {500, 601, 730}) {
    EXPECT_NEAR(rmsAbove(100, tone(210, samples), kPeriod), std::sqrt(0.5), 0.01) << samples;
    EXPECT_NEAR(rmsAbove(100, tone(83, samples), kPeriod), 0, 0.001) << samples;
  }
}

TEST(RmsAbove, IsNotFooledByAnOffsetOrASlowRamp) {
  std::vector<Vec3> force;
  for (int i = 0; i < 600; ++i) force.emplace_back(5 + 0.01 * i, 0, 0);
  EXPECT_LT(rmsAbove(100, force, kPeriod), 0.001);
}

TEST(RmsAbove, OfAlmostNothingIsNothing) { EXPECT_EQ(rmsAbove(100, tone(210, 3), kPeriod), 0); }

std::vector<double> wave(double periods, std::size_t samples) {
  std::vector<double> signal;
  for (std::size_t i = 0; i < samples; ++i) {
    signal.push_back(3 +
                     std::sin(2 * std::numbers::pi * periods * static_cast<double>(i) / static_cast<double>(samples)));
  }
  return signal;
}

TEST(PowerSpectrum, DividesTheMeanSquareOfTheSignalWithoutItsMean) {
  for (const std::size_t samples : {480, 481, 512}) {
    double sum = 0;
    for (const double power : powerSpectrum(wave(31.3, samples))) sum += power;
    EXPECT_NEAR(sum, 0.5, 0.01) << samples;
  }
}

TEST(PowerSpectrum, PeaksWhereTheWaveIsAlsoBetweenTwoElements) {
  for (const double periods : {17.0, 17.3, 17.5, 40.9}) {
    EXPECT_NEAR(peakOf(powerSpectrum(wave(periods, 640))), periods, 0.06);
  }
}

TEST(PowerSpectrum, HasNoPeakWhereNothingChanges) { EXPECT_EQ(peakOf(powerSpectrum(std::vector<double>(64, 2.0))), 0); }

}  // namespace
}  // namespace haptics::eval::spectrum_test
