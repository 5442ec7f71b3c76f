#include "common/surface/grain_field.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptics {
namespace {

constexpr double kScale = 1.0081844136;  ///< 1 / the deviation of a flattened normal distribution.
constexpr double kGrainHighest = 3 * kScale;
constexpr double kGrainSlope = 23,
                 kGrainCurvature = 200;  ///< For grains of 1 m: above the largest of 2 * 10^7 samples.

using Vec4 = glm::dvec4;  // gradient, value

/// Mean 0, variance 1, excess kurtosis -0.04: how many of 48 bits are set, smeared over the step between two counts.
double normal(std::uint64_t bits) noexcept {
  constexpr int kCounted = 48;
  constexpr double kInverseDeviation = 0.2876779808912305;  // (48 / 4 + 1 / 12)^(-1/2)
  const int above = std::popcount(bits << (64 - kCounted)) - kCounted / 2;
  const double smeared = static_cast<double>(bits >> kCounted) * 0x1p-16 + (0x1p-17 - 0.5);
  return (above + smeared) * kInverseDeviation;
}

/// Weights of two neighbours whose squares add up to 1, and their slopes.
struct Weights {
  double first, second, firstSlope, secondSlope;
};
Weights weights(double t) noexcept {
  const Ramp b = fade(t);
  const double a = 1 - b.value;
  const double inverse = 1 / std::sqrt(a * a + b.value * b.value);
  const double slope = b.slope * inverse * inverse * inverse;
  return {a * inverse, b.value * inverse, -slope * b.value, slope * a};
}

Vec4 blended(const Vec4& a, const Vec4& b, const Weights& w, int axis) noexcept {
  Vec4 both = w.first * a + w.second * b;
  both[axis] += w.firstSlope * a.w + w.secondSlope * b.w;
  return both;
}

/// Above kKnee bent down to end level at kTop; scaled so that a normal distribution keeps its variance of 1.
Ramp flattened(double x) noexcept {
  constexpr double kKnee = 2, kEnd = 4;
  const double size = std::abs(x);
  const double over = std::clamp(size - kKnee, 0.0, kEnd - kKnee);
  const double value = std::min(size, kEnd) - over * over / (2 * (kEnd - kKnee));
  const double slope = size < kEnd ? 1 - over / (kEnd - kKnee) : 0;
  return {kScale * std::copysign(value, x), kScale * slope};
}

}  // namespace

GrainField::GrainField(const GrainFamily& family)
    : ScalarField({-kGrainHighest, kGrainHighest, kGrainSlope / family.grain_m,
                   kGrainCurvature / (family.grain_m * family.grain_m)},
                  family.grain_m),
      lattice_(family.grain_m, family.seed) {}

FieldSample GrainField::at(Vec3 point) const noexcept {
  const CellLattice::Place place = lattice_.place(point);
  const Weights x = weights(place.within.x), y = weights(place.within.y), z = weights(place.within.z);
  const auto corner = [&place](int i, int j, int k) {
    return Vec4(0, 0, 0, normal(CellLattice::bits(place.key, i, j, k)));
  };
  const auto along = [&](int j, int k) { return blended(corner(0, j, k), corner(1, j, k), x, 0); };
  const Vec4 sum = blended(blended(along(0, 0), along(1, 0), y, 1), blended(along(0, 1), along(1, 1), y, 1), z, 2);
  const Ramp flat = flattened(sum.w);
  return {flat.value, lattice_.gradient(flat.slope * Vec3(sum))};
}

}  // namespace haptics
