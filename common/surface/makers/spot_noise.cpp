#include "common/surface/makers/spot_noise.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "common/interruption/interruption.h"
#include "common/surface/lattice.h"
#include "common/surface/makers/computed_field.h"

namespace haptics {
namespace {

constexpr double kHalfHeight = 0.5411961001;  ///< Where (1 - r^2)^2 is 1/2: sqrt(1 - sqrt(1/2)).
/// Spots over each place on average: with fewer single spots are felt, more change little.
constexpr double kOverlap = 16;

/// A spot's centre and radii in samples.
struct Spot {
  double x, y, radiusX, radiusY, strength;
};

void add(const Spot& spot, std::uint32_t side, std::vector<double>& values) {
  const auto wrapped = [n = static_cast<std::int64_t>(side)](std::int64_t i) { return ((i % n) + n) % n; };
  const auto first = [](double centre, double radius) { return static_cast<std::int64_t>(std::ceil(centre - radius)); };
  for (std::int64_t y = first(spot.y, spot.radiusY); static_cast<double>(y) < spot.y + spot.radiusY; ++y) {
    const double partY = (static_cast<double>(y) - spot.y) / spot.radiusY;
    double* row = values.data() + wrapped(y) * side;
    for (std::int64_t x = first(spot.x, spot.radiusX); static_cast<double>(x) < spot.x + spot.radiusX; ++x) {
      const double partX = (static_cast<double>(x) - spot.x) / spot.radiusX;
      const double inside = 1 - partX * partX - partY * partY;
      if (inside > 0) row[wrapped(x)] += spot.strength * inside * inside;
    }
  }
}

}  // namespace

SampledField spotNoise(const SpotNoiseSource& source) {
  const double side = source.resolution;
  const double radiusY = side / source.cells / (2 * kHalfHeight);
  const double radiusX = radiusY * source.elongation;
  const double area = std::numbers::pi * radiusX * radiusY;
  const auto spots = static_cast<int>(std::ceil(kOverlap * side * side / area));

  Random random(source.seed);
  std::vector<double> values(std::size_t{source.resolution} * source.resolution);
  for (int i = 0; i < spots; ++i) {
    interruptionPoint();
    const double x = side * random.uniform(), y = side * random.uniform();
    add({x, y, radiusX, radiusY, 2 * random.uniform() - 1}, source.resolution, values);
  }
  return zeroMeanField(source.resolution, values);
}

}  // namespace haptics
