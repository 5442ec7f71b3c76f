#include "haptic_server/device/usb/arm_kinematics.h"

#include <cmath>
#include <glm/matrix.hpp>

#include "common/maths/elementary.h"

namespace haptics {
namespace {

using Forearm = ArmKinematics;

/// From the column's axis to the hand.
[[nodiscard]] double radiusAt(Vec3 angles) noexcept {
  return Forearm::kUpper_m * elementary::sin(angles.y) + Forearm::kForearm_m * elementary::sin(angles.z);
}

}  // namespace

Vec3 ArmKinematics::positionAt(Vec3 angles) noexcept {
  const double radius = radiusAt(angles);
  return Vec3(elementary::cos(angles.x) * radius, elementary::sin(angles.x) * radius,
              kColumn_m + kUpper_m * elementary::cos(angles.y) - kForearm_m * elementary::cos(angles.z)) -
         kOrigin;
}

std::optional<Vec3> ArmKinematics::anglesAt(Vec3 position) noexcept {
  const Vec3 p = position + kOrigin;
  const double radius = elementary::hypot(p.x, p.y), height = p.z - kColumn_m;
  if (!(radius > kMinRadius_m)) return std::nullopt;
  // Bodies b and c point along (sin b, cos b) and (sin c, -cos c) in the plane of radius and height: c is turned by
  // pi - c from the vertical, elbow above when that is more than b.
  const double reach = elementary::hypot(radius, height);
  const double cosine = (reach * reach - kUpper_m * kUpper_m - kForearm_m * kForearm_m) / (2 * kUpper_m * kForearm_m);
  if (!(std::abs(cosine) < 1)) return std::nullopt;
  const double bend = elementary::acos(cosine);
  const double towards = elementary::atan2(radius, height);
  const double b = towards - elementary::atan2(kForearm_m * elementary::sin(bend), kUpper_m + kForearm_m * cosine);
  const Vec3 angles(elementary::atan2(p.y, p.x), b, elementary::acos(-1) - (b + bend));
  if (nearSingular(angles)) return std::nullopt;
  return angles;
}

glm::dmat3 ArmKinematics::positionByAngles(Vec3 angles) noexcept {
  const double radius = radiusAt(angles);
  const double ca = elementary::cos(angles.x), sa = elementary::sin(angles.x);
  const double cb = elementary::cos(angles.y), sb = elementary::sin(angles.y);
  const double cc = elementary::cos(angles.z), sc = elementary::sin(angles.z);
  return {Vec3(-sa * radius, ca * radius, 0), Vec3(ca * cb, sa * cb, -sb) * kUpper_m,
          Vec3(ca * cc, sa * cc, sc) * kForearm_m};
}

Vec3 ArmKinematics::torquesFor(Vec3 force_N, Vec3 angles) noexcept {
  return glm::transpose(positionByAngles(angles)) * force_N;
}

bool ArmKinematics::nearSingular(Vec3 angles) noexcept {
  return !(radiusAt(angles) > kMinRadius_m) || std::abs(elementary::sin(angles.y + angles.z)) < kMinSine;
}

}  // namespace haptics
