#pragma once

#include <vector>

#include "common/scene/surface_properties.h"
#include "common/surface/lattice.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// Perlin's gradient noise in space (Perlin 1985, 2002; Ebert et al. 1994): random gradients of length sqrt(2) at the
/// points of a lattice, of side wavelength_m, and their ramps blended by a quintic, so that even the curvature is
/// continuous. Octaves: a fractal sum of such. Scaled so that it stays within -1 and 1.
class NoiseField final : public ScalarField {
 public:
  explicit NoiseField(const NoiseFamily& family);
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override;

 private:
  struct Octave {
    CellLattice lattice;
    double amplitude;
  };
  std::vector<Octave> octaves_;

  [[nodiscard]] static std::vector<Octave> octavesOf(const NoiseFamily& family);
  [[nodiscard]] static FieldBounds boundsOf(const NoiseFamily& family);
};

}  // namespace haptics
