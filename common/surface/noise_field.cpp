#include "common/surface/noise_field.h"

#include <array>
#include <cmath>

#include "common/maths/sse.h"

namespace haptics {
namespace {

/// Gradient and value, two numbers to a register.
struct Noise {
  __m128d xy;
  __m128d zAndValue;
};

/// Along the edges of a cube: Perlin's (2002) twelve, whose mean square is the same in every direction. The fourth number
/// is not used.
alignas(32) constexpr std::array<std::array<double, 4>, 12> kGradients{{{1, 1, 0},
                                                                        {-1, 1, 0},
                                                                        {1, -1, 0},
                                                                        {-1, -1, 0},
                                                                        {1, 0, 1},
                                                                        {-1, 0, 1},
                                                                        {1, 0, -1},
                                                                        {-1, 0, -1},
                                                                        {0, 1, 1},
                                                                        {0, -1, 1},
                                                                        {0, 1, -1},
                                                                        {0, -1, -1}}};

// The highest noise is that of a cell whose gradients all are the best for one place in it: with them, each corner gives
// its weight times the sum of the two largest components of the way to it.
constexpr double kNoiseHighest = 1.0363538112118;  ///< There.
constexpr Vec3 kHighestAt(0.5, 0.481492214, 0.355256701);
constexpr double kNoiseSlope = 3.2,
                 kNoiseCurvature = 13.5;  ///< For wavelength 1 m: above the largest of 2 * 10^7 samples.

/// @param xy, z  Of the way from the corner.
Noise corner(std::uint64_t bits, __m128d xy, __m128d z) noexcept {
  const double* const g = kGradients[(bits >> 32) * kGradients.size() >> 32].data();
  const __m128d gradient = _mm_load_pd(g), gradientZ = _mm_load_sd(g + 2);
  const __m128d along = gradient * xy;
  const __m128d sum = _mm_add_sd(_mm_add_sd(along, _mm_unpackhi_pd(along, along)), _mm_mul_sd(gradientZ, z));
  return {gradient, _mm_unpacklo_pd(gradientZ, sum)};
}

/// Between two that lie a step apart along an axis; the weight's own slope counts.
template <int axis>
Noise blended(const Noise& a, const Noise& b, Ramp weight) noexcept {
  const __m128d value = _mm_set1_pd(weight.value);
  const __m128d more = b.zAndValue - a.zAndValue;
  const __m128d slope = _mm_mul_sd(_mm_unpackhi_pd(more, more), _mm_set_sd(weight.slope));
  Noise both{a.xy + value * (b.xy - a.xy), a.zAndValue + value * more};
  if (axis == 0) both.xy = _mm_add_sd(both.xy, slope);
  if (axis == 1) both.xy = _mm_unpacklo_pd(both.xy, _mm_add_sd(_mm_unpackhi_pd(both.xy, both.xy), slope));
  if (axis == 2) both.zAndValue = _mm_add_sd(both.zAndValue, slope);
  return both;
}

Noise noise(const CellLattice::Place& place) noexcept {
  const Vec3 p = place.within;
  const Ramp x = fade(p.x), y = fade(p.y), z = fade(p.z);
  const __m128d xy[2][2] = {{_mm_setr_pd(p.x, p.y), _mm_setr_pd(p.x, p.y - 1)},
                            {_mm_setr_pd(p.x - 1, p.y), _mm_setr_pd(p.x - 1, p.y - 1)}};
  const __m128d fromZ[2] = {_mm_set_sd(p.z), _mm_set_sd(p.z - 1)};
  const auto along = [&](unsigned j, unsigned k) noexcept {
    return blended<0>(corner(CellLattice::bits(place.key, 0, j, k), xy[0][j], fromZ[k]),
                      corner(CellLattice::bits(place.key, 1, j, k), xy[1][j], fromZ[k]), x);
  };
  return blended<2>(blended<1>(along(0, 0), along(1, 0), y), blended<1>(along(0, 1), along(1, 1), y), z);
}

}  // namespace

NoiseField::NoiseField(const NoiseFamily& family)
    : ScalarField(boundsOf(family), std::ldexp(family.wavelength_m, 1 - static_cast<int>(family.octaves))),
      octaves_(octavesOf(family)) {}

FieldBounds NoiseField::boundsOf(const NoiseFamily& family) {
  FieldBounds bounds{-1, 1, 0, 0};
  double amplitude = 1, sum = 0, wavelength_m = family.wavelength_m;
  for (std::uint32_t i = 0; i < family.octaves; ++i) {
    bounds.slope_per_m += amplitude * kNoiseSlope / wavelength_m;
    bounds.curvature_per_m2 += amplitude * kNoiseCurvature / (wavelength_m * wavelength_m);
    sum += amplitude;
    amplitude *= family.persistence;
    wavelength_m /= 2;
  }
  bounds.slope_per_m /= sum;
  bounds.curvature_per_m2 /= sum;
  return bounds;
}

/// The lattices are shifted so that the places where octaves can be highest coincide: the sum of their bounds is reached.
std::vector<NoiseField::Octave> NoiseField::octavesOf(const NoiseFamily& family) {
  std::vector<Octave> octaves;
  Random seeds(family.seed);
  double amplitude = 1, sum = 0, side_m = family.wavelength_m, finer = 1;
  for (std::uint32_t i = 0; i < family.octaves; ++i) {
    octaves.push_back({CellLattice(side_m, seeds.bits(), kHighestAt * (1 - finer)), amplitude / kNoiseHighest});
    sum += amplitude;
    amplitude *= family.persistence;
    side_m /= 2;
    finer *= 2;
  }
  for (Octave& octave : octaves) octave.amplitude /= sum;
  return octaves;
}

FieldSample NoiseField::at(Vec3 point) const noexcept {
  FieldSample sum;
  for (const Octave& octave : octaves_) {
    const Noise n = noise(octave.lattice.place(point));
    const __m128d amplitude = _mm_set1_pd(octave.amplitude);
    const __m128d xy = n.xy * amplitude, zAndValue = n.zAndValue * amplitude;
    sum.value += zAndValue[1];
    sum.gradient += octave.lattice.gradient({xy[0], xy[1], zAndValue[0]});
  }
  return sum;
}

}  // namespace haptics
