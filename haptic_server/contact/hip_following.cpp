#include "haptic_server/contact/hip_following.h"

#include <bit>

#include "haptic_server/geometry/neighbours.h"

namespace haptics {
namespace {

/// A half space that the HIP is within at value 0 and more: when does it go out?
[[nodiscard]] double timeWithin(double atFrom, double atTo) noexcept {
  if (atTo >= atFrom || atTo >= 0) return 1;
  return std::max(atFrom, 0.0) / (atFrom - atTo);
}

/// Beside the plane through edge k along the triangle's normal, on the inner side; `side` -1 for the outer.
[[nodiscard, gnu::always_inline]] inline double timeBeside(const TriangleRecord& record, int k, double side,
                                                           const HipMotion& motion) noexcept {
  const Vec3 a = record.corner(k);
  const Vec3 inward = glm::cross(record.areaNormal(), record.corner(nextCorner(k)) - a) * side;
  return timeWithin(glm::dot(inward, motion.from - a), glm::dot(inward, motion.to - a));
}

/// Where the HIP goes out of a prism that it is beyond at the end.
struct Exit {
  double time = 2;
  int edge = 0;
};
[[nodiscard]] Exit exitFrom(const TriangleRecord& record, const Prism& atEnd, const HipMotion& motion) noexcept {
  const unsigned beyond = atEnd.beyond();
  if (std::has_single_bit(beyond)) {  // nearly always, and free of branches that nobody can predict
    const int k = std::countr_zero(beyond);
    return {timeBeside(record, k, 1, motion), k};
  }
  Exit exit;
  for (int k = 0; k < 3; ++k) {
    if ((beyond >> k & 1) == 0) continue;
    const double time = timeBeside(record, k, 1, motion);
    if (time < exit.time) exit = {time, k};
  }
  return exit;
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

bool followOverPolygons(const Surface& surface, const HipMotion& motion, int side, Foot& foot, double& now,
                        SearchPath* path, int& spent) noexcept {
  ++spent;
  while (true) {
    const TriangleRecord& record = surface.triangle(foot.triangle);
    const Prism prism(record, all(motion.to));
    if (prism.holds()) {
      foot.point = vec3(prism.foot(four(motion.to)));
      if (path != nullptr) path->add(foot.point, foot.triangle);
      now = 1;
      return true;
    }
    const Exit exit = exitFrom(record, prism, motion);
    now = std::max(now, exit.time);
    const int line = sameLineAcross(surface, foot.triangle, exit.edge);
    if (line < 0 || spent >= kSearchBudget) return false;
    ++spent;
    const TriangleRecord& next = surface.triangle(record.neighbour(exit.edge));
    double enters = now;
    Prism over(next, all(motion.at(now)));
    if ((over.beyond() >> line & 1) != 0) {  // a valley: the line holds the IHIP for a while
      enters = std::max(now, timeBeside(next, line, -1, motion));
      over = Prism(next, all(motion.at(enters)));
    }
    const bool isOutside = (over.height() >= 0) == (side > 0);
    if (isOutside || (over.beyond() & ~(1U << line)) != 0) return false;
    if (path != nullptr) {
      const Vec3 h = motion.at(now);
      foot.point = vec3(Prism(record, all(h)).foot(four(h)));
      path->add(foot.point, foot.triangle);
    }
    if (enters >= 1) {
      if (!isAlong(record, exit.edge, motion.to)) return false;
      foot = {foot.triangle, Feature::kLine, static_cast<std::uint8_t>(exit.edge)};
      foot.point = onLine(record, exit.edge, motion.to);
      if (path != nullptr) path->add(foot.point, foot.triangle);
      now = 1;
      return true;
    }
    now = enters;
    foot.triangle = record.neighbour(exit.edge);
    foot.point = vec3(over.foot(four(motion.at(now))));
    if (path != nullptr) path->add(foot.point, foot.triangle);
  }
}

double timeInRegion(const Surface& surface, const Foot& foot, const HipMotion& motion, double now) noexcept {
  constexpr int kMostPolygons = 32;  // around a vertex; a larger fan is searched in short steps
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
    return std::max(now, time);
  }
  int polygons = 0;
  const auto staysBehindLines = [&](const TriangleRecord& r, int corner) noexcept {
    for (const int other : {nextCorner(corner), previousCorner(corner)}) {
      const Vec3 back = start - r.corner(other);
      time = std::min(time, timeWithin(glm::dot(back, motion.from - start), glm::dot(back, motion.to - start)));
    }
    return ++polygons < kMostPolygons;
  };
  staysBehindLines(record, foot.index);
  visitFan(surface, foot.triangle, foot.index,
           [&](std::uint32_t t, int corner) noexcept { return staysBehindLines(surface.triangle(t), corner); });
  return polygons < kMostPolygons ? std::max(now, time) : now;
}

}  // namespace haptics
