#include "tests/eval/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace haptics::eval {

/// By Parseval: all power less that of the low frequencies' bins.
double rmsAbove(double frequency_Hz, std::span<const Vec3> force_N, double period_s) {
  constexpr std::size_t kFewest = 16;
  const std::size_t count = force_N.size();
  if (count < kFewest) return 0;
  Vec3 mean(0);
  for (const Vec3 f : force_N) mean += f;
  mean /= static_cast<double>(count);

  const double turn = 2 * std::numbers::pi / static_cast<double>(count);
  std::vector<double> cosine(count);
  std::vector<double> sine(count);
  for (std::size_t i = 0; i < count; ++i) {
    cosine[i] = std::cos(turn * static_cast<double>(i));
    sine[i] = std::sin(turn * static_cast<double>(i));
  }
  std::vector<Vec3> windowed;
  double window2 = 0;
  double power = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double window = 0.5 * (1 - cosine[i]);
    windowed.push_back((force_N[i] - mean) * window);
    window2 += window * window;
    power += squaredLength(windowed.back());
  }
  const auto lowBins = static_cast<std::size_t>(frequency_Hz * period_s * static_cast<double>(count));
  for (std::size_t bin = 0; bin <= std::min(lowBins, count / 2); ++bin) {
    Vec3 real(0);
    Vec3 imaginary(0);
    for (std::size_t i = 0; i < count; ++i) {
      real += windowed[i] * cosine[bin * i % count];
      imaginary += windowed[i] * sine[bin * i % count];
    }
    const bool paired = bin != 0 && 2 * bin != count;
    power -= (paired ? 2 : 1) * (squaredLength(real) + squaredLength(imaginary)) / static_cast<double>(count);
  }
  return std::sqrt(std::max(0.0, power) / window2);
}

}  // namespace haptics::eval
