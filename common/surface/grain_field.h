#pragma once

#include "common/scene/surface_properties.h"
#include "common/surface/lattice.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// Sandpaper (Green & Salisbury 1997 vary friction by its mean and variance): normally distributed values at the points
/// of a lattice, blended by weights whose squares add up to 1, so that the mean is 0 and the variance 1 everywhere and
/// not at the lattice's points alone. Grains above 2 are flattened to reach 3 at most (one in 22 is touched).
class GrainField final : public ScalarField {
 public:
  explicit GrainField(const GrainFamily& family);
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override;

 private:
  CellLattice lattice_;
};

}  // namespace haptics
