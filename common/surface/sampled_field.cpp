#include "common/surface/sampled_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/surface/cubic_spline.h"

namespace haptics {
namespace {

/// Into [0, period), as whole and fraction.
struct Split {
  std::size_t cell;
  double within;
};
Split split(double x, std::uint32_t period, double turnsPerStep) noexcept {
  const double wrapped = x - period * std::floor(x * turnsPerStep);
  if (!(wrapped >= 0 && wrapped < period)) return {0, 0};  // rounding may pass either end
  const auto cell = static_cast<std::size_t>(wrapped);
  return {cell, wrapped - static_cast<double>(cell)};
}

}  // namespace

Result<void> checkSides(std::uint32_t width, std::uint32_t height) {
  for (const auto& [name, side] : {std::pair("width", width), std::pair("height", height)}) {
    if (side >= kMinFieldSide && side <= kMaxFieldSide) continue;
    return refused(name, "is " + std::to_string(side) + " samples; " + std::to_string(kMinFieldSide) + " to " +
                             std::to_string(kMaxFieldSide) + " are taken");
  }
  return {};
}

Result<SampledField> SampledField::make(std::uint32_t width, std::uint32_t height, std::vector<float> samples) {
  if (auto ok = checkSides(width, height); !ok) return tl::unexpected(std::move(ok).error());
  if (samples.size() != std::size_t{width} * height) {
    return refused("samples", "are " + std::to_string(samples.size()) + "; width * height is " +
                                  std::to_string(std::size_t{width} * height));
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!(std::abs(samples[i]) <= kMaxFieldValue)) {
      return refused("samples[" + std::to_string(i) + "]",
                     "is not a finite number of at most " + std::to_string(static_cast<int>(kMaxFieldValue)));
    }
  }
  SplineGrid grid = interpolatingGrid(width, height, samples);
  return SampledField(std::move(samples), std::move(grid));
}

SampledField::SampledField(std::vector<float> samples, SplineGrid grid)
    : samples_(std::move(samples)),
      grid_(std::move(grid)),
      bounds_(boundsOf(grid_, samples_)),
      perWidth_(1.0 / grid_.width),
      perHeight_(1.0 / grid_.height),
      mean_(std::accumulate(samples_.begin(), samples_.end(), 0.0) / static_cast<double>(samples_.size())) {}

SampledField::Sample SampledField::at(double x, double y) const noexcept {
  const auto [cellX, withinX] = split(x, grid_.width, perWidth_);
  const auto [cellY, withinY] = split(y, grid_.height, perHeight_);
  const SplineWeights wx = splineWeights(withinX), wy = splineWeights(withinY);

  // Over the rows first: four columns at a time.
  std::array<double, 4> column{}, columnSlope{};
  const float* row = grid_.around(cellX, cellY);
  for (int i = 0; i < 4; ++i, row += grid_.stride()) {
    for (int j = 0; j < 4; ++j) {
      column[j] += wy.value[i] * row[j];
      columnSlope[j] += wy.slope[i] * row[j];
    }
  }
  Sample sample{0, {0, 0}};
  for (int j = 0; j < 4; ++j) {
    sample.value += wx.value[j] * column[j];
    sample.gradient.x += wx.slope[j] * column[j];
    sample.gradient.y += wx.value[j] * columnSlope[j];
  }
  return sample;
}

}  // namespace haptics
