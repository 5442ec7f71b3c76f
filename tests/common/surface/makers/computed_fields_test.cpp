#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "common/surface/field_asset.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/makers/spot_noise.h"

namespace haptics::computed_fields_test {
namespace {

using std::numbers::pi;
using Pattern = ReactionDiffusionSource::Pattern;

/// Power by whole waves along a tile's side, whatever their direction.
std::vector<double> powerByWaveNumber(const SampledField& field, int highest) {
  const int side = static_cast<int>(field.width());
  std::vector<double> power(highest + 2);
  const auto turn = [side](int waves, int at) { return std::polar(1.0, -2 * pi * ((waves * at) % side) / side); };
  for (int kx = 0; kx <= highest; ++kx) {
    std::vector<std::complex<double>> rows(side);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) rows[y] += static_cast<double>(field.samples()[y * side + x]) * turn(kx, x);
    }
    for (int ky = -highest; ky <= highest; ++ky) {
      std::complex<double> sum = 0;
      for (int y = 0; y < side; ++y) sum += rows[y] * turn(ky, y);
      const auto number = static_cast<std::size_t>(std::lround(std::hypot(kx, ky)));
      if (number < power.size()) power[number] += std::norm(sum) * (kx == 0 ? 1 : 2);
    }
  }
  return power;
}

double meanWaveNumber(const std::vector<double>& power) {
  double sum = 0, moment = 0;
  for (std::size_t k = 1; k < power.size(); ++k) {
    sum += power[k];
    moment += static_cast<double>(k) * power[k];
  }
  return moment / sum;
}

void expectZeroMeanAndUnitPeak(const SampledField& field) {
  float largest = 0;
  for (const float sample : field.samples()) largest = std::max(largest, std::abs(sample));
  EXPECT_EQ(largest, 1);
  EXPECT_NEAR(field.mean(), 0, 1e-7);
}

double skewness(const SampledField& field) {
  double squares = 0, cubes = 0;
  for (const double sample : field.samples()) {
    squares += sample * sample;
    cubes += sample * sample * sample;
  }
  const double count = static_cast<double>(field.samples().size());
  return cubes / count / std::pow(squares / count, 1.5);
}

TEST(ReactionDiffusion, MakesAsManySpotsOrStripesAsAskedFor) {
  for (const Pattern pattern : {Pattern::kSpots, Pattern::kStripes}) {
    for (const std::uint32_t cells : {5U, 12U}) {
      const SampledField field = reactionDiffusion({pattern, cells, 128, 3});
      expectZeroMeanAndUnitPeak(field);
      const auto power = powerByWaveNumber(field, static_cast<int>(2 * cells) - 1);
      EXPECT_NEAR(meanWaveNumber(power), cells, 0.1 * cells);
      const auto peak = std::max_element(power.begin(), power.end()) - power.begin();
      EXPECT_NEAR(static_cast<double>(peak), cells, 1);
    }
  }
}

TEST(ReactionDiffusion, MakesSpotsThatStandOutAndStripesThatAreAsHighAsDeep) {
  EXPECT_GT(skewness(reactionDiffusion({Pattern::kSpots, 8, 128, 1})), 0.7);
  EXPECT_NEAR(skewness(reactionDiffusion({Pattern::kStripes, 8, 128, 1})), 0, 0.2);
}

TEST(ReactionDiffusion, OfALargerResolutionIsTheSamePattern) {
  const SampledField coarse = reactionDiffusion({Pattern::kStripes, 6, 96, 1});
  const SampledField fine = reactionDiffusion({Pattern::kStripes, 6, 192, 1});
  for (int i = 0; i < 96; ++i) EXPECT_NEAR(fine.at(2 * i, i).value, coarse.at(i, 0.5 * i).value, 0.03);
}

/// What a spot has in common with itself moved aside, by sums over a fine grid; 1 when not moved. Radius 1.
double spotsOverlap(double aside) {
  const auto spot = [](double x, double y) {
    const double inside = std::max(0.0, 1 - x * x - y * y);
    return inside * inside;
  };
  double moved = 0, whole = 0;
  for (double x = -2; x < 2; x += 0.02) {
    for (double y = -1; y < 1; y += 0.02) {
      moved += spot(x - aside / 2, y) * spot(x + aside / 2, y);
      whole += spot(x, y) * spot(x, y);
    }
  }
  return moved / whole;
}

/// Correlation of the field with itself some samples away, over many seeds.
double correlation(SpotNoiseSource source, int alongX, int alongY) {
  double moved = 0, whole = 0;
  for (source.seed = 1; source.seed <= 12; ++source.seed) {
    const SampledField field = spotNoise(source);
    const auto side = static_cast<int>(source.resolution);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const double here = field.samples()[y * side + x];
        moved += here * field.samples()[(y + alongY) % side * side + (x + alongX) % side];
        whole += here * here;
      }
    }
  }
  return moved / whole;
}

TEST(SpotNoise, HasTheSpectrumOfItsSpot) {
  // By Wiener and Khinchin: its correlation is that of the spot. Radius: half a width / 0.5412.
  const SpotNoiseSource source{16, 1, 128, 1};
  const double radius = 128.0 / 16 / 2 / 0.5412;
  for (const int aside : {2, 4, 6, 8, 12, 16}) {
    EXPECT_NEAR(correlation(source, aside, 0), spotsOverlap(aside / radius), 0.04) << aside;
    EXPECT_NEAR(correlation(source, 0, aside), spotsOverlap(aside / radius), 0.04) << aside;
  }
}

TEST(SpotNoise, IsAsMuchLongerAlongXAsItsSpots) {
  const SpotNoiseSource source{16, 3, 128, 1};
  for (const int aside : {2, 4, 6}) EXPECT_NEAR(correlation(source, 3 * aside, 0), correlation(source, 0, aside), 0.05);
}

TEST(SpotNoise, IsPeriodicWithZeroMeanAndUnitPeak) {
  for (const double elongation : {1.0, 8.0}) {
    const SampledField field = spotNoise({2, elongation, 64, 9});
    expectZeroMeanAndUnitPeak(field);
    double border = 0, middle = 0;
    for (int y = 0; y < 64; ++y) {
      border = std::max<double>(border, std::abs(field.samples()[y * 64 + 63] - field.samples()[y * 64]));
      middle = std::max<double>(middle, std::abs(field.samples()[y * 64 + 31] - field.samples()[y * 64 + 32]));
    }
    EXPECT_LT(border, 3 * middle);
  }
}

TEST(ComputedFields, DifferBySeedAndAreTheSameOnEveryMachine) {
  const auto pattern = [](Pattern which, std::uint32_t seed) {
    return hashOf(reactionDiffusion({which, 4, 32, seed})).hex();
  };
  const auto spots = [](std::uint32_t seed) { return hashOf(spotNoise({4, 1.5, 32, seed})).hex(); };
  EXPECT_NE(pattern(Pattern::kSpots, 1), pattern(Pattern::kSpots, 2));
  EXPECT_NE(spots(1), spots(2));
  EXPECT_EQ(pattern(Pattern::kSpots, 1), "1835c76fbfcaaff39df1dc8a85f5dd10166a9066b5a84e71bc78b2d453396482");
  EXPECT_EQ(pattern(Pattern::kStripes, 1), "2e3f550094f3660971f37e18aef91aa2b8e4f5df9b8c6fe83d130e0da3ac01f9");
  EXPECT_EQ(spots(1), "d75a7b007b63c5d70fe13539f3254dfa215fa67d47b4376f9cd687426ef689da");
}

}  // namespace
}  // namespace haptics::computed_fields_test
