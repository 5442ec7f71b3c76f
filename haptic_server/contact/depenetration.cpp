#include "haptic_server/contact/depenetration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/contact/plane_set.h"
#include "haptic_server/geometry/enclosure.h"

namespace haptics {
namespace {

/// Where a point is inside of a body.
struct Depth {
  double depth_m = 0;
  Vec3 foot{0};  ///< World.
  Vec3 normal{0};
};

/// What a place has to be outside of, or on its side of, and what may yet be asked of it.
class Bodies {
 public:
  Bodies(std::span<const Body> bodies, const NearBodies& near, ContactWork& work) noexcept
      : bodies_(bodies), near_(near), work_(work) {}

  /// Half of the segments are kept for the ways out.
  [[nodiscard]] bool mayLook() const noexcept {
    return triangles_ > 0 && segments_ > kMaxDepenetrationSegments / 2 && !work_.allowance.isSpent();
  }
  [[nodiscard]] bool mayCross() const noexcept { return segments_ > 0 && !work_.allowance.isSpent(); }

  /// In the body that it is the deepest in, else behind the sheet that is first on the way to it; depth 0 when there is
  /// none.
  [[nodiscard]] Depth deepest(Vec3 at) noexcept {
    Depth deepest;
    lookAtAll();
    for (const Body& body : bodies_) {
      if (!isClosed(body) || !withinSphere(body, at) || !mayLook() || winding(body, at) <= 0) continue;
      const Depth depth = depthIn(body, at);
      if (depth.depth_m > deepest.depth_m) deepest = depth;
    }
    return deepest.depth_m > 0 ? deepest : behindSheet(at);
  }

  /// Fraction of the way to a place that is outside of all at which the last one of those that hold `at` lets out; 0 when
  /// none does.
  [[nodiscard]] double timeOutside(Vec3 at, Vec3 to) noexcept {
    double time = 0;
    lookAtAll();
    for (const Body& body : bodies_) {
      if (!isClosed(body) || !withinSphere(body, at)) continue;
      const int around = winding(body, at);
      if (around <= 0) continue;
      count();
      time = std::max(time,
                      leavesAt(*body.surface, around, body.frame.toLocal(at), body.frame.toLocal(to), work_.allowance));
    }
    return time;
  }

  /// Behind no sheet that is near?
  [[nodiscard]] bool isOnItsSide(Vec3 at) noexcept { return behindSheet(at).depth_m == 0; }

  /// The way from a place that is outside of all, as far as it enters nothing. Asks whatever was asked before.
  [[nodiscard]] double clearTime(Vec3 from, Vec3 to) noexcept {
    double time = 1;
    for (const Body& body : bodies_) {
      if (body.pendingRemoval) continue;
      count();
      const Crossing crossing =
          body.surface->firstCrossing(body.frame.toLocal(from), body.frame.toLocal(to), work_.allowance);
      if (crossing) time = std::min(time, crossing.time);
    }
    return time;
  }

  /// Farther than this from the place there is no body.
  [[nodiscard]] double reachFrom(Vec3 place) const noexcept {
    double reach = 0;
    for (const Body& body : bodies_) {
      if (!body.pendingRemoval) reach = std::max(reach, glm::distance(place, body.centre) + body.surface->radius_m());
    }
    return reach;
  }

 private:
  static bool isClosed(const Body& body) noexcept { return !body.pendingRemoval && body.surface->closed(); }

  void lookAtAll() noexcept { work_.allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies_.size())); }
  void count() noexcept {
    --segments_;
    ++work_.segments;
  }

  int winding(const Body& body, Vec3 at) noexcept {
    count();
    return windingNumber(*body.surface, body.frame.toLocal(at), work_.allowance);
  }

  Depth behindSheet(Vec3 at) noexcept {
    Depth first;
    double time = 1;
    for (int i = 0; i < near_.count(); ++i) {
      const NearBodies::Near& near = near_[i];
      if (near.pendingRemoval || near.surface->closed()) continue;
      const Vec3 to = near.frame.toLocal(at);
      if (near.from == to) continue;
      count();
      const Crossing crossing = near.surface->firstCrossing(near.from, to, work_.allowance);
      if (!crossing || (crossing.time >= time && first.depth_m > 0)) continue;
      time = crossing.time;
      const Vec3 normal = near.surface->faceNormal(crossing.triangle) * static_cast<double>(crossing.side);
      const Vec3 foot = glm::mix(near.from, to, time);
      // also for a point on the sheet itself
      const double depth = std::max(glm::dot(normal, foot - to), std::numeric_limits<double>::min());
      first = {depth, near.frame.toWorld(foot), near.frame.rotate(normal)};
    }
    return first;
  }

  Depth depthIn(const Body& body, Vec3 at) noexcept {
    const CollisionMesh& s = *body.surface;
    const Vec3 local = body.frame.toLocal(at);
    int looked = 0;
    Allowance part(work_.allowance.left() / 4);
    const std::int64_t before = part.left();
    ClosestPoint foot = s.closestFoot(local, triangles_, looked, part);
    work_.allowance.spend(before - part.left());
    if (foot.triangle == kNoTriangle) return {};
    int hopped = 0;
    foot = neighborhoodWatch(s, foot.triangle, local, nullptr, hopped, searchBudget(work_.allowance, work_.triangles))
               .foot;
    triangles_ -= looked + hopped;
    work_.triangles += looked + hopped;
    work_.allowance.spend(Allowance::kNearTriangle * hopped);
    return {std::sqrt(foot.squaredDistance), body.frame.toWorld(foot.point), body.frame.rotate(s.normal(foot))};
  }

  std::span<const Body> bodies_;
  const NearBodies& near_;
  ContactWork& work_;
  int triangles_ = kMaxDepenetrationTriangles;
  int segments_ = kMaxDepenetrationSegments;
};

/// Above the planes of all that is in the way, met one after the other. None when they leave no room, or when that is not
/// known in time.
std::optional<Vec3> abovePlanes(Bodies& bodies, Vec3 from, double skin) noexcept {
  PlaneSet planes;
  Vec3 at = from;
  while (bodies.mayLook()) {
    const Depth inside = bodies.deepest(at);
    if (inside.depth_m == 0) return bodies.mayLook() ? std::optional(at) : std::nullopt;
    if (planes.full()) return std::nullopt;
    planes.add({inside.normal, glm::dot(inside.normal, inside.foot) + skin, {}});
    const auto nearest = planes.nearest(from, skin / 4);
    if (!nearest) return std::nullopt;
    at = nearest->point;
  }
  return std::nullopt;
}

/// In each direction out of what holds the place, then out of what holds the place that this leads to; the nearest.
Vec3 throughBodies(Bodies& bodies, Vec3 from, Vec3 outward, double skin) noexcept {
  constexpr double kThird = 0.57735026918962576;  // root of
  std::array<Vec3, 15> directions{outward, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (std::size_t i = 0; i < 8; ++i) {
    directions[7 + i] = Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1) * kThird;
  }
  const double reach = bodies.reachFrom(from) + skin;
  double nearest = reach;
  Vec3 place = from;
  for (const Vec3 direction : directions) {
    if (direction == Vec3(0)) continue;
    const Vec3 beyond = from + direction * reach;
    double way = 0;
    while (way < nearest && bodies.mayCross()) {
      const Vec3 at = from + direction * way;
      const double out = bodies.timeOutside(at, beyond);
      if (out == 0) {
        if (!bodies.isOnItsSide(at)) break;
        nearest = way;
        place = at;
      } else {
        way += out * (reach - way) + skin;
      }
    }
  }
  if (nearest < reach) return place;
  Vec3 way = outward == Vec3(0) ? directions[1] : outward;
  for (const Vec3 direction : directions) {
    if (direction == Vec3(0) || !bodies.isOnItsSide(from + direction * reach)) continue;
    way = direction;
    break;
  }
  const Vec3 beyond = from + way * reach;
  return glm::mix(beyond, from, bodies.clearTime(beyond, from) * (1 - skin / reach));
}

}  // namespace

std::optional<Vec3> findDepenetration(std::span<const Body> bodies, const NearBodies& near, Vec3 from, Vec3 outward,
                                      double skin, ContactWork& work) noexcept {
  Bodies all(bodies, near, work);
  const auto open = abovePlanes(all, from, skin);
  const bool isOpen = open && glm::distance(*open, from) <= all.reachFrom(from) + skin;  // nearly parallel planes
  if (isOpen) return open;
  const Vec3 out = throughBodies(all, from, outward, skin);
  return work.allowance.isSpent() ? std::nullopt : std::optional(out);
}

}  // namespace haptics
