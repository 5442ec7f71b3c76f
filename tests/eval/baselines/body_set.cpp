#include "tests/eval/baselines/body_set.h"

#include <algorithm>
#include <cmath>

namespace haptics::eval {

double BodySet::extent_m() const {
  double extent = 0;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    extent = std::max(extent, surfaces_[i]->extent_m() + glm::length(poses_[i].position));
  }
  return extent;
}

BodySet::Hit BodySet::firstCrossing(Vec3 from, Vec3 to) const {
  Hit hit;
  for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
    const Vec3 a = toLocal(pose(i), from);
    const Vec3 b = toLocal(pose(i), to);
    const Crossing crossing =
        test_ == SegmentTest::kWatertight ? surface(i).firstCrossing(a, b) : firstByRay(surface(i), a, b);
    if (crossing && (!hit || crossing.time < hit.crossing.time)) hit = {i, crossing};
  }
  return hit;
}

Crossing BodySet::firstByRay(const Surface& surface, Vec3 from, Vec3 to) {
  Crossing first;
  const Vec3 d = to - from;
  surface.hierarchy().visitAlong(from, to, [&](std::uint32_t begin, std::uint32_t end) noexcept {
    for (std::uint32_t t = begin; t < end; ++t) {
      const TriangleRecord& r = surface.triangle(t);
      const Vec3 edge1 = r.corner(1) - r.corner(0);
      const Vec3 edge2 = r.corner(2) - r.corner(0);
      const Vec3 p = glm::cross(d, edge2);
      const double determinant = glm::dot(edge1, p);
      if (determinant <= 0) continue;  // the paper's epsilon, 1e-6, would make it depend on the unit of length
      const Vec3 s = from - r.corner(0);
      const double u = glm::dot(s, p);
      if (u < 0 || u > determinant) continue;
      const Vec3 q = glm::cross(s, edge1);
      const double v = glm::dot(d, q);
      if (v < 0 || u + v > determinant) continue;
      const double time = glm::dot(edge2, q) / determinant;
      if (time >= 0 && time <= 1 && (!first || time < first.time)) first = {t, time, 1};
    }
    return first.time;
  });
  return first;
}

BodySet::Nearest BodySet::nearest(Vec3 hip) const {
  Nearest best;
  bool found = false;
  int triangles = 0;
  for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
    const Surface& s = surface(i);
    const Vec3 local = toLocal(pose(i), hip);
    const Foot foot = s.closestFoot(local, static_cast<int>(s.triangleCount()) + 1, triangles);
    const double distance = std::sqrt(foot.squaredDistance);
    const bool inside = s.closed() && !s.isOutside(foot, local);
    const bool better = inside == best.inside ? (distance < best.distance_m) != inside : inside;
    if (found && !better) continue;
    best = {inside, toWorld(pose(i), foot.point), pose(i).rotation * s.normal(foot), distance, 0};
    found = true;
  }
  best.triangles = triangles;
  return best;
}

}  // namespace haptics::eval
