#include "common/surface/cellular_field.h"

#include <array>
#include <cmath>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

// For cells of 1 m: above the largest of 4 * 10^6 samples at smoothness 0.02, 0.05, ... 1.
constexpr double kCellSlope = 2.5, kCellCurvature = 37, kCrease = 4;

/// A scattered point within reach, seen from the place asked about.
struct Near {
  Vec3 away;       ///< From the point to the place, in cells.
  double squared;  ///< Of its length, below 1.
  double rounded;  ///< Distance, rounded off near 0.
};

struct Neighbors {
  std::array<Near, 27> list;
  int count = 0;
};

double uniform21(std::uint64_t bits) noexcept { return static_cast<double>(bits & 0x1fffff) * 0x1p-21; }

Neighbors neighborsOf(const CellLattice::Place& place, double rounding) noexcept {
  const Vec3 t = place.within;
  // Squared distances along each axis to the cells that are -1, 0 and 1 steps away.
  const std::array<Vec3, 3> gaps{t * t, Vec3(0), (1.0 - t) * (1.0 - t)};
  Neighbors neighbors;
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      const double gap = gaps[j + 1].y + gaps[k + 1].z;
      for (int i = -1; i <= 1; ++i) {
        if (gap + gaps[i + 1].x >= 1) continue;
        const std::uint64_t bits = CellLattice::bits(place.key, i, j, k);
        const Vec3 away = t - Vec3(i + uniform21(bits), j + uniform21(bits >> 21), k + uniform21(bits >> 42));
        const double squared = squaredLength(away);
        if (squared >= 1) continue;
        neighbors.list[neighbors.count++] = {away, squared, std::sqrt(squared + rounding * rounding)};
      }
    }
  }
  return neighbors;
}

/// Lets a point fade out before it leaves the 27 cells that are looked at: by the squared distance, from 1/2 to 1.
Ramp reach(double squared) noexcept {
  if (squared <= 0.5) return {1, 0};
  const Ramp out = fade(2 * squared - 1);
  return {1 - out.value, -2 * out.slope};
}

FieldBounds boundsOf(const CellularFamily& family) {
  const double cell_m = family.cell_m;
  return {0, 1, kCellSlope / cell_m, (kCellCurvature + kCrease / family.smoothness) / (cell_m * cell_m)};
}

}  // namespace

FieldSample CellularField::at(Vec3 point) const noexcept {
  const CellLattice::Place place = lattice_.place(point);
  const Neighbors neighbors = neighborsOf(place, nearest_);
  const double farthest = nearest_ + range_;
  double least = farthest;
  for (int i = 0; i < neighbors.count; ++i) least = std::min(least, neighbors.list[i].rounded);

  // The mean of the distances, `farthest` among them; its gradient once the mean is known.
  std::array<double, 27> weights;
  std::array<Ramp, 27> reaches;
  double sum = elementary::exp((least - farthest) / softness_);
  double moment = sum * farthest;
  for (int i = 0; i < neighbors.count; ++i) {
    const Near& near = neighbors.list[i];
    weights[i] = elementary::exp((least - near.rounded) / softness_);
    reaches[i] = reach(near.squared);
    sum += weights[i] * reaches[i].value;
    moment += weights[i] * reaches[i].value * near.rounded;
  }
  const double mean = moment / sum;
  Vec3 gradient(0);
  for (int i = 0; i < neighbors.count; ++i) {
    const Near& near = neighbors.list[i];
    const Ramp& r = reaches[i];
    const double over = near.rounded - mean;
    gradient += near.away * weights[i] * (r.value * (1 - over / softness_) / near.rounded + 2 * over * r.slope);
  }
  return {(mean - nearest_) / range_, lattice_.gradient(gradient / (sum * range_))};
}

CellularField::CellularField(const CellularFamily& family)
    : ScalarField(boundsOf(family), family.cell_m),
      lattice_(family.cell_m, family.seed),
      softness_(family.smoothness),
      nearest_(family.smoothness / 2),
      range_(std::sqrt(1 + nearest_ * nearest_) - nearest_) {}

}  // namespace haptics
