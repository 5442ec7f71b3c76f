#include "haptic_server/engine/contact/hip_following.h"

#include "haptic_server/engine/contact/triangle_step.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

/// Beside the plane through edge k along the triangle's normal, on the inner side; `side` -1 for the outer.
[[nodiscard, gnu::always_inline]] inline double timeBeside(const TriangleRecord& record, int k, double side,
                                                           const HipMotion& motion) noexcept {
  const Vec3 a = record.corner(k);
  const Vec3 inward = glm::cross(record.areaNormal(), record.corner(nextCorner(k)) - a) * side;
  return timeWithin(glm::dot(inward, motion.from - a), glm::dot(inward, motion.to - a));
}

/// Between the planes at the ends of edge k.
[[nodiscard]] bool isAlong(const TriangleRecord& record, int k, Vec3 h) noexcept {
  const Vec3 a = record.corner(k);
  const Vec3 b = record.corner(nextCorner(k));
  return glm::dot(h - a, b - a) > 0 && glm::dot(h - b, a - b) > 0;
}

[[nodiscard]] Vec3 onLine(const TriangleRecord& record, int k, Vec3 h) noexcept {
  const Vec3 a = record.corner(k);
  const Vec3 line = record.corner(nextCorner(k)) - a;
  return a + line * (glm::dot(h - a, line) / squaredLength(line));
}

}  // namespace

bool followOverPolygons(const CollisionMesh& surface, const HipMotion& motion, int side, ClosestPoint& foot,
                        double& now, SearchRun& run) noexcept {
  const Vec3x4 from = broadcast(motion.from);
  const Vec3x4 to = broadcast(motion.to);
  Prism prism(surface.triangle(foot.triangle));
  Prism::Coordinates end = prism.coordinates(to);
  const auto setFoot = [&](Vec3 point) noexcept {
    foot.point = point;
    run.add(point, foot.triangle);
  };
  const auto setFootUnder = [&](Vec3 h) noexcept {
    if (run.path != nullptr) setFoot(vec3(prism.foot(toDouble4(h), prism.coordinates(broadcast(h)).height())));
  };
  ++run.looked;
  while (end.beyond() != 0) {
    TriangleStep step;
    step.leave(prism.coordinates(from), end, now);
    now = step.leaves;
    step.across = sameLineAcross(surface, foot.triangle, step.edge);
    if (step.across < 0 || run.looked >= run.budget) return false;
    ++run.looked;
    const TriangleRecord& record = surface.triangle(foot.triangle);
    const Prism next(surface.triangle(record.neighbour(step.edge)));
    const Prism::Coordinates nextEnd = next.coordinates(to);
    if (!step.enter(next.coordinates(from), nextEnd, side)) return false;
    setFootUnder(motion.at(now));
    if (step.enters >= 1) {  // on the line of a valley
      if (!isAlong(record, step.edge, motion.to)) return false;
      now = 1;
      foot = {foot.triangle, Feature::kLine, static_cast<std::uint8_t>(step.edge)};
      setFoot(onLine(record, step.edge, motion.to));
      return true;
    }
    now = step.enters;
    prism = next;
    end = nextEnd;
    foot.triangle = record.neighbour(step.edge);
    setFootUnder(motion.at(now));
  }
  setFoot(vec3(prism.foot(toDouble4(motion.to), end.height())));
  now = 1;
  return true;
}

double timeInRegion(const CollisionMesh& surface, const ClosestPoint& foot, const HipMotion& motion,
                    double now) noexcept {
  constexpr int kMaxPolygons = 32;  // around a vertex; a larger fan is searched in short steps
  const TriangleRecord& record = surface.triangle(foot.triangle);
  const Vec3 start = record.corner(foot.index);
  double time = 1;
  if (foot.feature == Feature::kLine) {
    const Vec3 end = record.corner(nextCorner(foot.index));
    const Vec3 line = end - start;
    time = std::min({timeWithin(glm::dot(line, motion.from - start), glm::dot(line, motion.to - start)),
                     timeWithin(glm::dot(line, end - motion.from), glm::dot(line, end - motion.to)),
                     timeBeside(record, foot.index, -1, motion)});
    const int across = sameLineAcross(surface, foot.triangle, foot.index);
    if (across >= 0) {
      const TriangleRecord& other = surface.triangle(record.neighbour(foot.index));
      time = std::min(time, timeBeside(other, across, -1, motion));
    }
    return time;
  }
  int polygons = 0;
  const auto staysBehindLines = [&](const TriangleRecord& r, int corner) noexcept {
    for (const int other : {nextCorner(corner), previousCorner(corner)}) {
      const Vec3 back = start - r.corner(other);
      time = std::min(time, timeWithin(glm::dot(back, motion.from - start), glm::dot(back, motion.to - start)));
    }
    return ++polygons < kMaxPolygons;
  };
  staysBehindLines(record, foot.index);
  visitFan(surface, foot.triangle, foot.index,
           [&](std::uint32_t t, int corner) noexcept { return staysBehindLines(surface.triangle(t), corner); });
  return polygons < kMaxPolygons ? time : now;
}

/// The same of a polygon's prism.
[[nodiscard]] double timeInPrism(const TriangleRecord& record, const HipMotion& motion) noexcept {
  return std::min(
      {timeBeside(record, 0, 1, motion), timeBeside(record, 1, 1, motion), timeBeside(record, 2, 1, motion)});
}

double leaveRegion(const CollisionMesh& surface, const HipMotion& motion, int side, double now, int number,
                   SearchResult& found, SearchRun& run) noexcept {
  found.converged = false;
  const double before = now;
  double along = 0;
  if (found.foot.feature != Feature::kPolygon) {
    const double left = timeInRegion(surface, found.foot, motion, now);
    now = std::max(now, left);
    along = kAlongBoundary * (now - left);
  } else if (followOverPolygons(surface, motion, side, found.foot, now, run)) {
    found.converged = true;
    return 1;
  } else if (now == before) {
    along = kAlongBoundary * (now - timeInPrism(surface.triangle(found.foot.triangle), motion));
  }
  const double least = number <= kMaxSteps / 2 ? kMinStep : kLongStep;
  return std::min(1.0, now + std::max(least, along));
}

HipStep followHip(const CollisionMesh& surface, const HipMotion& motion, int side, const ClosestPoint& foot, double now,
                  int number, SearchRun& run) noexcept {
  HipStep step{1, {foot, false}};
  step.end = leaveRegion(surface, motion, side, now, number, step.found, run);
  if (step.found.converged) return step;
  step.found = neighborhoodWatch(surface, step.found.foot.triangle, motion.at(step.end), run);
  return step;
}

}  // namespace haptics
