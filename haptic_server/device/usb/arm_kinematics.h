#pragma once

#include <glm/mat3x3.hpp>
#include <optional>

#include "common/maths/vec.h"

namespace haptics {

/// WoodenHaptics 1.5 (Forsslund et al. 2015): a serial arm of three bodies driven by capstans. Body a turns about the
/// vertical; b and c, both measured against a, lean in its plane: b from the vertical, c from the downward vertical.
/// Device frame, metres, origin kOrigin from the foot of the column: x towards the user, y to the user's right, z up.
struct ArmKinematics {
  static constexpr double kColumn_m = 0.080;   ///< Body a.
  static constexpr double kUpper_m = 0.205;    ///< Body b.
  static constexpr double kForearm_m = 0.245;  ///< Body c.
  static constexpr Vec3 kOrigin{0.220, 0, 0.080};
  /// Angles at the rest pose, where the encoders count from: b upright, c level.
  static constexpr Vec3 kRestAngles{0, 0, 1.5707963267948966};
  /// Closer to the column's axis, or to stretched or folded arms (sine of the angle between b and c), position and force
  /// are no longer to be told from one another.
  static constexpr double kMinRadius_m = 0.02, kMinSine = 0.05;

  /// Closed form: every set of angles is a position.
  [[nodiscard]] static Vec3 positionAt(Vec3 angles) noexcept;
  /// None where the arm does not reach, or reaches only in a singular pose. The elbow is above.
  [[nodiscard]] static std::optional<Vec3> anglesAt(Vec3 position) noexcept;
  /// Derivative of the position by the angles, m/rad.
  [[nodiscard]] static glm::dmat3 positionByAngles(Vec3 angles) noexcept;
  /// Torques of the bodies (N m, along growing angles) that push the hand with a force (N): J^T F.
  [[nodiscard]] static Vec3 torquesFor(Vec3 force_N, Vec3 angles) noexcept;
  [[nodiscard]] static bool nearSingular(Vec3 angles) noexcept;
};

}  // namespace haptics
