#include "common/surface/spline_grid.h"

#include <cmath>

namespace haptics {
namespace {

/// Pole of the filter that takes samples to coefficients: sqrt(3) - 2.
constexpr double kPole = -0.26794919243112270647;
constexpr std::size_t kMemory =
    30;  ///< Its powers after so many samples are below double's rounding: 0.268^30 = 7e-18.

/// In place: samples of one period to coefficients.
void filter(std::vector<double>& line) {
  const std::size_t n = line.size();
  // What the recursion has come to before the first sample, in a line that has always been periodic.
  double state = 0;
  for (std::size_t i = kMemory; i > 0; --i) state = kPole * state + line[(n * kMemory - i) % n];
  for (double& value : line) value = state = value + kPole * state;

  state = 0;
  for (std::size_t i = kMemory; i > 0; --i) state = kPole * (state - line[(i - 1) % n]);
  for (std::size_t i = n; i > 0; --i) line[i - 1] = 6 * (state = kPole * (state - line[i - 1]));
}

}  // namespace

SplineGrid interpolatingGrid(std::uint32_t width, std::uint32_t height, std::span<const float> samples) {
  std::vector<double> whole(samples.begin(), samples.end());
  std::vector<double> line(width);
  for (std::size_t y = 0; y < height; ++y) {
    double* row = whole.data() + y * width;
    line.assign(row, row + width);
    filter(line);
    std::copy(line.begin(), line.end(), row);
  }
  line.resize(height);
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t y = 0; y < height; ++y) line[y] = whole[y * width + x];
    filter(line);
    for (std::size_t y = 0; y < height; ++y) whole[y * width + x] = line[y];
  }

  SplineGrid grid{width, height, {}};
  grid.coefficients.reserve((width + std::size_t{3}) * (height + std::size_t{3}));
  for (std::size_t y = 0; y < height + std::size_t{3}; ++y) {
    const double* row = whole.data() + (y + height - 1) % height * width;
    for (std::size_t x = 0; x < width + std::size_t{3}; ++x) {
      grid.coefficients.push_back(static_cast<float>(row[(x + width - 1) % width]));
    }
  }
  return grid;
}

}  // namespace haptics
