#pragma once

#include "common/scene/surface_properties.h"
#include "common/surface/lattice.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// Worley's (1996) cellular texture F1: the distance to the nearest of points that are scattered in space, one in each
/// cell of a lattice, from 0 at a point to 1 where none is within a cell's side. Worley's own has cones around the points
/// and creases between them; here distances are rounded off at the points, sqrt(r^2 + (smoothness / 2)^2), and the least
/// is taken softly, as their mean weighted by exp(-distance / smoothness), both in cells. Above a smoothness of
/// about 0.2 the distant points weigh in everywhere: the field then stays above 0 even at its points (0.13 at 0.5).
class CellularField final : public ScalarField {
 public:
  explicit CellularField(const CellularFamily& family);
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override;

 private:
  CellLattice lattice_;
  double softness_;  // of the minimum, in cells
  double nearest_,
      range_;  // what rounding makes of the distances 0 and 1: their least, and how far they reach above it
};

}  // namespace haptics
