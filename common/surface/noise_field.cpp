#include "common/surface/noise_field.h"

#include <array>
#include <cmath>

namespace haptics {
namespace {

using Vec4 = glm::dvec4;  // gradient, value

/// Along the edges of a cube: Perlin's (2002) twelve, whose mean square is the same in every direction.
constexpr std::array<std::array<double, 3>, 12> kGradients{{{1, 1, 0},
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
constexpr double kHighest = 1.0363538112118;  ///< There.
constexpr Vec3 kHighestAt(0.5, 0.481492214, 0.355256701);
constexpr double kSlope = 3.2, kCurvature = 13.5;  ///< For wavelength 1 m: above the largest of 2 * 10^7 samples.

Vec4 corner(std::uint64_t key, Vec3 within, int x, int y, int z) noexcept {
  const std::uint64_t bits = Lattice::bits(key, x, y, z);
  const auto& g = kGradients[(bits >> 32) * kGradients.size() >> 32];
  return {g[0], g[1], g[2], g[0] * (within.x - x) + g[1] * (within.y - y) + g[2] * (within.z - z)};
}

/// Between two that lie a step apart along an axis; the weight's own slope counts.
Vec4 blended(const Vec4& a, const Vec4& b, Ramp weight, int axis) noexcept {
  Vec4 both = a + weight.value * (b - a);
  both[axis] += weight.slope * (b.w - a.w);
  return both;
}

Vec4 noise(const Lattice::Place& place) noexcept {
  const Ramp x = fade(place.within.x), y = fade(place.within.y), z = fade(place.within.z);
  const auto along = [&](int j, int k) {
    return blended(corner(place.key, place.within, 0, j, k), corner(place.key, place.within, 1, j, k), x, 0);
  };
  return blended(blended(along(0, 0), along(1, 0), y, 1), blended(along(0, 1), along(1, 1), y, 1), z, 2);
}

}  // namespace

NoiseField::NoiseField(const NoiseFamily& family)
    : ScalarField(boundsOf(family), std::ldexp(family.wavelength_m, 1 - static_cast<int>(family.octaves))),
      octaves_(octavesOf(family)) {}

FieldBounds NoiseField::boundsOf(const NoiseFamily& family) {
  FieldBounds bounds{-1, 1, 0, 0};
  double amplitude = 1, sum = 0, wavelength_m = family.wavelength_m;
  for (std::uint32_t i = 0; i < family.octaves; ++i) {
    bounds.slope_per_m += amplitude * kSlope / wavelength_m;
    bounds.curvature_per_m2 += amplitude * kCurvature / (wavelength_m * wavelength_m);
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
    octaves.push_back({Lattice(side_m, seeds.bits(), kHighestAt * (1 - finer)), amplitude / kHighest});
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
    const Vec4 n = octave.amplitude * noise(octave.lattice.place(point));
    sum.value += n.w;
    sum.gradient += octave.lattice.gradient(Vec3(n));
  }
  return sum;
}

}  // namespace haptics
