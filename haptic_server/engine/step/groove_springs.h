#pragma once

#include <array>
#include <cstddef>

#include "common/maths/vec.h"
#include "haptic_server/engine/contact/contact.h"

namespace haptics {

/// Of two normals: of closer ones no part can be told from the other's, nor the direction of their groove; they count as one.
inline constexpr double kMinSquaredSine = 1e-4;

/// The springs of two or three surfaces that hold the IHIP, each as stiff as its body. Of p, from the HIP to the IHIP, the
/// energy is
///
///   E = k(p / |p|) p^2 / 2,  F = grad E = k p + (p^2 / 2) grad k,  k = sum w_i k_i,
///
/// where p lies between the normals n_1 and n_2, at an angle a of the A that they are apart, w_2 = sin^2(pi a / 2 A) and
/// w_1 = 1 - w_2. So one body's spring goes over into the other's without a step of the force, and loops give nothing; with
/// normals at right angles each spring has its own part of p, F = sum k_i p_i n_i. Each with its own part at any other angle
/// is a field with a curl. Between three normals it is the three pairs' law, each by the nearness of p to its plane.
///
/// Normals closer together than kMinAngle have only a part of the second term, which goes as 1 / A^2 and is not to
/// shake the device; there loops may give. Not in the paper, whose IHIP one object holds.
class GrooveSprings {
 public:
  static constexpr double kMinAngle = 0.7;  // rad

  /// Outward, unit, world.
  void add(Vec3 normal, double spring_N_per_m) noexcept {
    normal_[count_] = normal;
    spring_N_per_m_[count_++] = spring_N_per_m;
  }

  [[nodiscard]] Vec3 force_N(Vec3 penetration_m) const noexcept;
  /// Weight of each spring; their sum is 1.
  [[nodiscard]] std::array<double, ContactState::kMaxHolding> weights(Vec3 penetration_m) const noexcept;

 private:
  struct Between;
  /// The first two normals that are apart; where none are, the first and itself.
  [[nodiscard]] std::array<std::size_t, 2> apart() const noexcept;
  [[nodiscard]] double stiffness_N_per_m(Vec3 penetration_m) const noexcept;

  std::array<Vec3, ContactState::kMaxHolding> normal_;
  std::array<double, ContactState::kMaxHolding> spring_N_per_m_;
  std::size_t count_ = 0;
};

}  // namespace haptics
