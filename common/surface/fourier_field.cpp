#include "common/surface/fourier_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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
    : ScalarField(boundsOf(waves), shortestWavelengthOf(waves)), waves_(std::move(waves)) {}

FieldSample FourierField::at(Vec3 point) const noexcept {
  FieldSample sum;
  for (const PlaneWave& wave : waves_) {
    const double angle = glm::dot(wave.k, point) + wave.phase_rad;
    sum.value += wave.amplitude * std::cos(angle);
    sum.gradient -= wave.amplitude * std::sin(angle) * wave.k;
  }
  return sum;
}

}  // namespace haptics
