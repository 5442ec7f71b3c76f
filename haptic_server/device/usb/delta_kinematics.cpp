#include "haptic_server/device/usb/delta_kinematics.h"

#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

using Delta = DeltaKinematics;

constexpr double kDegree_rad = std::numbers::pi / 180;

/// One arm in its own frame: u outwards, v to its side, w along z.
struct Arm {
  double cosine, sine;

  explicit Arm(double angle_rad) noexcept : cosine(elementary::cos(angle_rad)), sine(elementary::sin(angle_rad)) {}
  [[nodiscard]] Vec3 toArm(Vec3 p) const noexcept {
    return {cosine * p.x + sine * p.y - Delta::kBaseRadius_m, -sine * p.x + cosine * p.y - Delta::kBaseOffset_m, p.z};
  }
};

const std::array kArms{Arm(105 * kDegree_rad), Arm(-15 * kDegree_rad), Arm(-135 * kDegree_rad)};

/// Thigh, shin in the thigh's plane, shin's lean to the side.
struct Joints {
  double thigh, shin;
  elementary::SineCosine lean;
};

[[nodiscard]] std::optional<Joints> jointsAt(Vec3 inArm) noexcept {
  const double cosLean = (inArm.y + Delta::kSideOffset_m) / Delta::kShin_m;
  if (!(std::abs(cosLean) < 1)) return std::nullopt;
  const elementary::SineCosine lean = elementary::sineCosine(elementary::acos(cosLean));
  const double reach = Delta::kUpperOffset_m + Delta::kLowerOffset_m + Delta::kShin_m * lean.sine;
  const double u = inArm.x + Delta::kHandOffset_m, w = inArm.z;
  const double e = -2 * Delta::kThigh_m * u, f = -2 * Delta::kThigh_m * w;
  const double g = u * u + w * w + Delta::kThigh_m * Delta::kThigh_m - reach * reach;
  const double discriminant = e * e + f * f - g * g;
  if (!(discriminant > 0)) return std::nullopt;
  const double thigh = 2 * elementary::atan2(-f - std::sqrt(discriminant), g - e);
  const auto [sine, cosine] = elementary::sineCosine(thigh);
  const double shin = elementary::atan2(w - Delta::kThigh_m * sine, u - Delta::kThigh_m * cosine);
  return Joints{std::remainder(thigh, 2 * std::numbers::pi), shin, lean};
}

[[nodiscard]] Vec3 rowOf(const Arm& arm, const Joints& at) noexcept {
  const auto [sine, cosine] = elementary::sineCosine(at.shin);
  const Vec3 n(cosine * at.lean.sine, at.lean.cosine, sine * at.lean.sine);
  return Vec3(arm.cosine * n.x - arm.sine * n.y, arm.sine * n.x + arm.cosine * n.y, n.z) /
         (Delta::kThigh_m * at.lean.sine * elementary::sin(at.shin - at.thigh));
}

/// Angles and their derivatives (glm's columns are the rows).
struct Linearised {
  Vec3 angles;
  glm::dmat3 rows;
};

[[nodiscard]] std::optional<Linearised> linearise(Vec3 position) noexcept {
  Linearised at;
  for (int i = 0; i < 3; ++i) {
    const Arm& arm = kArms[static_cast<std::size_t>(i)];
    const auto joints = jointsAt(arm.toArm(position));
    if (!joints) return std::nullopt;
    at.angles[i] = joints->thigh;
    at.rows[i] = rowOf(arm, *joints);
  }
  return at;
}

[[nodiscard]] bool singular(const glm::dmat3& m) noexcept {
  const double determinant = glm::determinant(m);
  const double size = glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]);
  return !(std::abs(determinant) > 1e-6 * size);
}

[[nodiscard]] std::optional<Vec3> newton(Vec3 angles, Vec3 position) noexcept {
  constexpr int kMaxIterations = 20;
  constexpr double kClose_m = 1e-9;
  auto at = linearise(position);
  for (int i = 0; at && i < kMaxIterations; ++i) {
    const glm::dmat3 byPosition = glm::transpose(at->rows);
    if (singular(byPosition)) return std::nullopt;
    Vec3 step = glm::inverse(byPosition) * (angles - at->angles);
    const double length = glm::length(step);
    if (!std::isfinite(length)) return std::nullopt;
    if (length < kClose_m) return position + step;
    if (length > Delta::kMaxStep_m) step *= Delta::kMaxStep_m / length;
    auto there = linearise(position + step);
    for (int halvings = 0; !there && halvings < 8; ++halvings) {
      step *= 0.5;
      there = linearise(position + step);
    }
    position += step;
    at = there;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vec3> DeltaKinematics::anglesAt(Vec3 position) noexcept {
  const auto at = linearise(position);
  if (!at) return std::nullopt;
  return at->angles;
}

glm::dmat3 DeltaKinematics::anglesByPosition(Vec3 position) noexcept {
  const auto at = linearise(position);
  return at ? glm::transpose(at->rows) : glm::dmat3(0);
}

std::optional<Vec3> DeltaKinematics::positionAt(Vec3 angles, Vec3 start) noexcept {
  if (!isFinite(angles)) return std::nullopt;
  if (isFinite(start)) {
    if (const auto found = newton(angles, start)) return found;
  }
  return newton(angles, kCentre);
}

Vec3 DeltaKinematics::torquesFor(Vec3 force_N, Vec3 position) noexcept {
  const auto at = linearise(position);
  if (!at || singular(at->rows)) return Vec3(0);
  // A = dangle/dx, J = A^-1: J^T F = A^-T F, and `rows` holds A^T.
  return glm::inverse(at->rows) * force_N;
}

}  // namespace haptics
