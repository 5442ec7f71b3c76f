#include "tests/eval/spectrum.h"

#include <algorithm>
#include <cmath>
#include <kissfft/kissfft.hh>
#include <numbers>

namespace haptics::eval {

std::vector<double> powerSpectrum(std::span<const double> signal) {
  const std::size_t count = signal.size();
  if (count < 2) return {};
  const auto n = static_cast<double>(count);
  double mean = 0;
  for (const double value : signal) mean += value / n;
  std::vector<std::complex<double>> windowed(count);
  std::vector<std::complex<double>> transformed(count);
  double window2 = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double window = 0.5 * (1 - std::cos(2 * std::numbers::pi * static_cast<double>(i) / n));
    windowed[i] = (signal[i] - mean) * window;
    window2 += window * window;
  }
  kissfft<double>(count, false).transform(windowed.data(), transformed.data());
  std::vector<double> power(count / 2 + 1);
  for (std::size_t i = 0; i < power.size(); ++i) {
    const bool paired = i != 0 && 2 * i != count;
    power[i] = (paired ? 2 : 1) * std::norm(transformed[i]) / (n * window2);
  }
  return power;
}

double peakOf(std::span<const double> spectrum, std::size_t from) {
  if (spectrum.size() < from + 2) return 0;
  const auto highest = std::max_element(spectrum.begin() + static_cast<std::ptrdiff_t>(from), spectrum.end() - 1);
  const auto at = static_cast<double>(highest - spectrum.begin());
  if (highest == spectrum.begin() || !(highest[-1] > 0) || !(highest[1] > 0)) return *highest > 0 ? at : 0;
  const double before = std::log(highest[-1]), here = std::log(highest[0]), after = std::log(highest[1]);
  const double bend = before - 2 * here + after;
  return bend < 0 ? at + 0.5 * (before - after) / bend : at;
}

double rmsAbove(double frequency_Hz, std::span<const Vec3> force_N, double period_s) {
  constexpr std::size_t kFewest = 16;
  const std::size_t count = force_N.size();
  if (count < kFewest) return 0;
  const auto lowBins = static_cast<std::size_t>(frequency_Hz * period_s * static_cast<double>(count));
  double power = 0;
  std::vector<double> along(count);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i) along[i] = force_N[i][axis];
    const std::vector<double> spectrum = powerSpectrum(along);
    for (std::size_t bin = lowBins + 1; bin < spectrum.size(); ++bin) power += spectrum[bin];
  }
  return std::sqrt(power);
}

}  // namespace haptics::eval
