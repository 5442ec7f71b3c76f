#include "tests/eval/baselines/body_set.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/baselines/moeller_trumbore.h"

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

Crossing BodySet::firstByRay(const CollisionMesh& surface, Vec3 from, Vec3 to) {
  Crossing first;
  const MoellerTrumbore ray(from, to);
  Allowance endless;
  surface.hierarchy().visitAlong(from, to, endless, [&](std::uint32_t begin, std::uint32_t end) noexcept {
    for (std::uint32_t t = begin; t < end; ++t) {
      Crossing crossing{t};
      if (ray.enters(surface.triangle(t), false, crossing) && (!first || crossing.time < first.time)) first = crossing;
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
    const CollisionMesh& s = surface(i);
    const Vec3 local = toLocal(pose(i), hip);
    const ClosestPoint foot = s.closestFoot(local, static_cast<int>(s.triangleCount()) + 1, triangles);
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
