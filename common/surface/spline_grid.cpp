#include "common/surface/spline_grid.h"

#include <algorithm>

#include "common/interruption/interruption.h"

namespace haptics {
namespace {

/// Pole of the filter that takes samples to coefficients: sqrt(3) - 2.
constexpr double kPole = -0.26794919243112270647;
constexpr std::size_t kMemory =
    30;  ///< Its powers after so many samples are below double's rounding: 0.268^30 = 7e-18.

/// In place: samples of one period to coefficients, along as many lines side by side as `state` has numbers.
void filter(double* samples, std::size_t count, std::vector<double>& state) {
  const std::size_t lines = state.size();
  // What each recursion has come to before the period, in lines that have always been periodic.
  std::fill(state.begin(), state.end(), 0.0);
  for (std::size_t i = kMemory; i > 0; --i) {
    const double* at = samples + (count * kMemory - i) % count * lines;
    for (std::size_t k = 0; k < lines; ++k) state[k] = kPole * state[k] + at[k];
  }
  for (std::size_t i = 0; i < count; ++i) {
    interruptionPoint();
    double* at = samples + i * lines;
    for (std::size_t k = 0; k < lines; ++k) at[k] = state[k] = at[k] + kPole * state[k];
  }

  std::fill(state.begin(), state.end(), 0.0);
  for (std::size_t i = kMemory; i > 0; --i) {
    const double* at = samples + (i - 1) % count * lines;
    for (std::size_t k = 0; k < lines; ++k) state[k] = kPole * (state[k] - at[k]);
  }
  for (std::size_t i = count; i > 0; --i) {
    interruptionPoint();
    double* at = samples + (i - 1) * lines;
    for (std::size_t k = 0; k < lines; ++k) {
      state[k] = kPole * (state[k] - at[k]);
      at[k] = 6 * state[k];
    }
  }
}

}  // namespace

SplineGrid interpolatingGrid(std::uint32_t width, std::uint32_t height, std::span<const float> samples) {
  std::vector<double> filtered(samples.begin(), samples.end());
  std::vector<double> state(1);
  for (std::size_t y = 0; y < height; ++y) filter(filtered.data() + y * width, width, state);
  state.resize(width);
  filter(filtered.data(), height, state);

  SplineGrid grid{width, height, {}};
  grid.coefficients.reserve((width + std::size_t{3}) * (height + std::size_t{3}));
  for (std::size_t y = 0; y < height + std::size_t{3}; ++y) {
    const double* row = filtered.data() + (y + height - 1) % height * width;
    for (std::size_t x = 0; x < width + std::size_t{3}; ++x) {
      grid.coefficients.push_back(static_cast<float>(row[(x + width - 1) % width]));
    }
  }
  return grid;
}

}  // namespace haptics
