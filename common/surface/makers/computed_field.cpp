#include "common/surface/makers/computed_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace haptics {

SampledField zeroMeanField(std::uint32_t side, std::span<const double> values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value - mean));
  std::vector<float> samples;
  samples.reserve(values.size());
  for (const double value : values) samples.push_back(static_cast<float>((value - mean) / largest));
  return SampledField::make(side, side, std::move(samples)).value();
}

}  // namespace haptics
