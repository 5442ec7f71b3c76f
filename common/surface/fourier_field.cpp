#include "common/surface/fourier_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/maths/sine_cosine.h"

namespace haptics {
namespace {

std::vector<PlaneWave> wavesOf(const FourierFamily& family) {
  std::vector<PlaneWave> waves;
  for (const FourierTerm& term : family.terms) {
    waves.push_back({term.amplitude, 2 * std::numbers::pi / term.wavelength_m * term.direction, term.phase_rad});
  }
  return waves;
}

FieldBounds boundsOf(const std::vector<PlaneWave>& waves) {
  const Range range = rangeOf(waves);
  FieldBounds bounds{range.lowest, range.highest, 0, 0};
  for (const PlaneWave& wave : waves) {
    bounds.slope_per_m += std::abs(wave.amplitude) * glm::length(wave.k);
    bounds.curvature_per_m2 += std::abs(wave.amplitude) * squaredLength(wave.k);
  }
  return bounds;
}

double shortestWavelengthOf(const std::vector<PlaneWave>& waves) {
  double steepest = 0;
  for (const PlaneWave& wave : waves) steepest = std::max(steepest, glm::length(wave.k));
  return 2 * std::numbers::pi / steepest;
}

}  // namespace

FourierField::FourierField(const FourierFamily& family) : FourierField(wavesOf(family)) {}

FourierField::FourierField(std::vector<PlaneWave> waves)
    : ScalarField(boundsOf(waves), shortestWavelengthOf(waves)), waves_((waves.size() + 1) / 2) {
  for (std::size_t i = 0; i < waves.size(); ++i) {
    TwoWaves& both = waves_[i / 2];
    both.amplitude[i % 2] = waves[i].amplitude;
    for (std::size_t axis = 0; axis < 3; ++axis) both.k[axis][i % 2] = waves[i].k[static_cast<int>(axis)];
    both.phase_rad[i % 2] = waves[i].phase_rad;
  }
}

FieldSample FourierField::at(Vec3 point) const noexcept {
  const __m128d x = _mm_set1_pd(point.x), y = _mm_set1_pd(point.y), z = _mm_set1_pd(point.z);
  const auto two = [](const std::array<double, 2>& numbers) { return _mm_load_pd(numbers.data()); };
  __m128d value = _mm_setzero_pd(), alongX = value, alongY = value, alongZ = value;
  for (const TwoWaves& wave : waves_) {
    const auto [sine, cosine] =
        sineCosine(two(wave.k[0]) * x + two(wave.k[1]) * y + two(wave.k[2]) * z + two(wave.phase_rad));
    value += two(wave.amplitude) * cosine;
    const __m128d slope = two(wave.amplitude) * sine;
    alongX -= slope * two(wave.k[0]);
    alongY -= slope * two(wave.k[1]);
    alongZ -= slope * two(wave.k[2]);
  }
  return {value[0] + value[1], {alongX[0] + alongX[1], alongY[0] + alongY[1], alongZ[0] + alongZ[1]}};
}

}  // namespace haptics
