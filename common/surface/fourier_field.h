#pragma once

#include <array>
#include <vector>

#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"
#include "common/surface/wave_range.h"

namespace haptics {

/// A Fourier series: a sum of plane waves. One wave is a grating; wavelengths that halve with the amplitudes are a fractal.
/// Bounds of slope and curvature: the waves' own added up, never passed.
class FourierField final : public ScalarField {
 public:
  explicit FourierField(const FourierFamily& family);
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override;

 private:
  /// One for each lane.
  struct alignas(16) TwoWaves {
    std::array<double, 2> amplitude{};
    std::array<std::array<double, 2>, 3> k{};  ///< rad/m: x of both, y, z.
    std::array<double, 2> phase_rad{};
  };

  std::vector<TwoWaves> waves_;  ///< The last lane of an odd number has amplitude 0.

  explicit FourierField(std::vector<PlaneWave> waves);
};

}  // namespace haptics
