#include "tests/eval/corrections_off.h"

#include "tests/eval/baselines/moeller_trumbore.h"

namespace haptics::eval {
namespace {

Vec3f corner(const TriangleRecord& record, int k) { return Vec3f(record.corner(k)); }

}  // namespace

bool entersByRay(Vec3 from, Vec3 to, const TriangleRecord& record, bool twoSided, Crossing& crossing) noexcept {
  return MoellerTrumbore(from, to).enters(record, twoSided, crossing);
}

bool entersAlone(Vec3 from, Vec3 to, const TriangleRecord& record, bool twoSided, Crossing& crossing) noexcept {
  return Segment(from, to).enters(record, twoSided, crossing);
}

ClosestPoint closestInFloat(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  const Vec3f at(h);
  const Vec3f normal = glm::cross(corner(record, 1) - corner(record, 0), corner(record, 2) - corner(record, 0));
  ClosestPoint foot;
  foot.triangle = triangle;
  const auto take = [&](Vec3f point, Feature feature, int index) {
    const Vec3f way = at - point;
    const float distance2 = glm::dot(way, way);
    if (!(distance2 < static_cast<float>(foot.squaredDistance))) return;
    foot = {triangle, feature, static_cast<std::uint8_t>(index), Vec3(point), distance2};
  };
  bool within = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3f a = corner(record, k);
    const Vec3f edge = corner(record, nextCorner(k)) - a;
    if (glm::dot(glm::cross(normal, edge), at - a) > 0) continue;
    within = false;
    const float along = glm::dot(at - a, edge);
    const float end = glm::dot(edge, edge);
    if (along <= 0) {
      take(a, Feature::kVertex, k);
    } else if (along >= end) {
      take(corner(record, nextCorner(k)), Feature::kVertex, nextCorner(k));
    } else {
      take(a + edge * (along / end), Feature::kLine, k);
    }
  }
  if (within)
    take(at - normal * (glm::dot(normal, at - corner(record, 0)) / glm::dot(normal, normal)), Feature::kPolygon, 0);
  return foot;
}

}  // namespace haptics::eval
