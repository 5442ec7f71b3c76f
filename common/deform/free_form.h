#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/deform/narrowed.h"
#include "common/maths/vec.h"

namespace haptics {

/// Free-form deformation (Sederberg & Parry, Free-Form Deformation of Solid Geometric Models, 1986; Basdogan's for the
/// paper's section 5 (d)): a box is filled by a trivariate Bernstein polynomial over a lattice of control points, and what
/// is in the box goes along. With the control points where they are at rest it changes nothing but for rounding. One
/// function for both processes.
class FreeForm {
 public:
  static constexpr std::uint32_t kMaxPoints = 8;  ///< Along an axis.

  /// @param low_m, size_m  The box at rest; each side > 0.
  /// @param points  Control points along x, y and z; each 2 to kMaxPoints.
  /// @param control_m  Where they are, x fastest. Outlives this.
  FreeForm(Vec3 low_m, Vec3 size_m, std::array<std::uint32_t, 3> points, std::span<const Vec3f> control_m)
      : low_(low_m), size_(size_m), points_(points), control_(control_m) {}

  /// Where the lattice moves a vertex in the box.
  [[nodiscard]] Vec3f operator()(Vec3f rest) const noexcept {
    std::array<Weights, 3> weight;
    for (int d = 0; d < 3; ++d) {
      const auto axis = static_cast<std::size_t>(d);
      weight[axis] = bernstein(points_[axis], (Vec3(rest)[d] - low_[d]) / size_[d]);
    }
    Vec3 sum(0);
    std::size_t i = 0;
    for (std::size_t z = 0; z < points_[2]; ++z) {
      for (std::size_t y = 0; y < points_[1]; ++y) {
        const double yz = weight[1][y] * weight[2][z];
        for (std::size_t x = 0; x < points_[0]; ++x) sum += Vec3(control_[i++]) * (weight[0][x] * yz);
      }
    }
    return narrowed(sum);
  }

  /// Where the control points of such a lattice are at rest.
  [[nodiscard]] static std::vector<Vec3f> atRest(Vec3 low_m, Vec3 size_m, std::array<std::uint32_t, 3> points) {
    std::vector<Vec3f> control;
    for (std::uint32_t z = 0; z < points[2]; ++z) {
      for (std::uint32_t y = 0; y < points[1]; ++y) {
        for (std::uint32_t x = 0; x < points[0]; ++x) {
          const Vec3 part(double(x) / (points[0] - 1), double(y) / (points[1] - 1), double(z) / (points[2] - 1));
          control.emplace_back(low_m + size_m * part);
        }
      }
    }
    return control;
  }

 private:
  using Weights = std::array<double, kMaxPoints>;

  /// By de Casteljau's recurrence.
  [[nodiscard]] static Weights bernstein(std::uint32_t points, double t) noexcept {
    Weights weight{1};
    for (std::size_t degree = 1; degree < points; ++degree) {
      double carried = 0;
      for (std::size_t i = 0; i <= degree; ++i) {
        const double own = i < degree ? weight[i] : 0;
        weight[i] = own * (1 - t) + carried;
        carried = own * t;
      }
    }
    return weight;
  }

  Vec3 low_, size_;
  std::array<std::uint32_t, 3> points_;
  std::span<const Vec3f> control_;
};

}  // namespace haptics
