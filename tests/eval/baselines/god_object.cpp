#include "tests/eval/baselines/god_object.h"

namespace haptics::eval {

Felt GodObject::tick(std::span<const Pose> poses, Vec3 hip) {
  bodies_.setPoses(poses);
  for (int i = 0; i < kMaxMoves; ++i) {
    const Vec3 before = god_;
    move(hip);
    if (activeCount_ == 0 || god_ == before) break;
  }
  if (activeCount_ == 0) return {false, hip, Vec3(0), 0};
  return {true, god_, spring_N_per_m() * (god_ - hip), 0};
}

void GodObject::move(Vec3 hip) {
  activeCount_ = 0;
  while (true) {
    const Vec3 to = goal(hip);
    const BodySet::Hit hit = bodies_.firstCrossing(god_, to);
    if (!hit) {
      god_ = to;
      return;
    }
    if (activeCount_ == kMaxActive) return;  // held in a point
    active_[static_cast<std::size_t>(activeCount_++)] = planeOf(hit);
  }
}

GodObject::Plane GodObject::planeOf(const BodySet::Hit& hit) const {
  constexpr double kSkin = 0x1p-20;
  const CollisionMesh& s = bodies_.surface(hit.body);
  const Pose& pose = bodies_.pose(hit.body);
  const Vec3 normal = pose.rotation * (s.faceNormal(hit.crossing.triangle) * static_cast<double>(hit.crossing.side));
  const Vec3 corner = toWorld(pose, s.triangle(hit.crossing.triangle).corner(0));
  return {normal, glm::dot(normal, corner) + kSkin * bodies_.extent_m()};
}

/// Minimises |x - hip|^2 / 2 on the active planes: x = hip + sum of multiplier_i * normal_i, by elimination on the
/// symmetric system of at most three multipliers. A plane that depends on the ones before it adds nothing.
Vec3 GodObject::goal(Vec3 hip) const {
  constexpr double kDependent = 0x1p-30;  // squared sine of the angle to the planes before
  Vec3 x = hip;
  std::array<Vec3, kMaxActive> axis;
  int axes = 0;
  for (int i = 0; i < activeCount_; ++i) {
    const Plane& plane = active_[static_cast<std::size_t>(i)];
    Vec3 free = plane.normal;  // the part along which x may still move without leaving the planes before
    for (int j = 0; j < axes; ++j)
      free -= axis[static_cast<std::size_t>(j)] * glm::dot(free, axis[static_cast<std::size_t>(j)]);
    const double free2 = squaredLength(free);
    if (free2 <= kDependent) continue;
    x += free * ((plane.offset_m - glm::dot(plane.normal, x)) / free2);
    axis[static_cast<std::size_t>(axes++)] = free / std::sqrt(free2);
  }
  return x;
}

}  // namespace haptics::eval
