#pragma once

#include <glm/mat3x3.hpp>
#include <optional>

#include "common/maths/vec.h"

namespace haptics {

/// The Novint Falcon's linkage: three arms at 120 degrees, each a driven thigh and a parallelogram shin (a delta robot
/// with offsets; Tsai & Stamper 1997, geometry as measured on the device by users). Device frame, metres: x to the right,
/// y up, z from the base towards the user. Angles in radians.
struct DeltaKinematics {
  static constexpr double kThigh_m = 0.060;          ///< a
  static constexpr double kShin_m = 0.1025;          ///< b
  static constexpr double kHandOffset_m = 0.01443;   ///< c, of the shin's joint on the moving platform
  static constexpr double kUpperOffset_m = 0.01125;  ///< d: the shin's hinges stand off from its parallelogram
  static constexpr double kLowerOffset_m = 0.01125;  ///< e
  static constexpr double kSideOffset_m = -0.025;    ///< f
  static constexpr double kBaseRadius_m = 0.0400;    ///< r
  static constexpr double kBaseOffset_m = -0.02309;  ///< s
  static constexpr Vec3 kCentre{0, 0, 0.13};         ///< Middle of the workspace.

  /// Angles of the three thighs at a position; none where the arms do not reach.
  [[nodiscard]] static std::optional<Vec3> anglesAt(Vec3 position) noexcept;

  /// Row i: derivative of angle i by the position, rad/m. The position must be reached.
  [[nodiscard]] static glm::dmat3 anglesByPosition(Vec3 position) noexcept;

  /// Position at which the thighs stand at these angles, found by Newton-Raphson from `start`, within 1e-9 m; none where
  /// there is none or the iteration does not get there. Steps are clamped to kMaxStep_m, halved where the arms do not
  /// reach, and the start is tried again from the middle.
  [[nodiscard]] static std::optional<Vec3> positionAt(Vec3 angles, Vec3 start) noexcept;

  /// Torques of the three axes (N m, along growing angles) that push the hand with a force (N): J^T F, J = dx/dangle.
  /// Zero at a singular position.
  [[nodiscard]] static Vec3 torquesFor(Vec3 force_N, Vec3 position) noexcept;
  static constexpr double kMaxStep_m = 0.02;
};

}  // namespace haptics
