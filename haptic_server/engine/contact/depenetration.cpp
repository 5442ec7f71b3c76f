#include "haptic_server/engine/contact/depenetration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "haptic_server/engine/contact/plane_set.h"
#include "haptic_server/engine/geometry/enclosure.h"

namespace haptics {
namespace {

/// Depth of a point inside of a body.
struct Depth {
  double depth_m = 0;
  Vec3 foot{0};  ///< World, as the normal there.
  Vec3 normal{0};
};

/// The bodies that a place has to be outside of, the sheets that it has to be on the contact side of, and the budget of
/// queries.
class DepenetrationQuery {
 public:
  DepenetrationQuery(std::span<const Body> bodies, const NearBodies& near, ContactWork& work) noexcept
      : bodies_(bodies), near_(near), work_(work), kept_(work.allowance.left() / 2) {}

  /// Half of the segments and of the allowance are kept for throughBodies().
  [[nodiscard]] bool hasQueryBudget() const noexcept {
    return triangles_ > 0 && segments_ > kMaxDepenetrationSegments / 2 && work_.allowance.left() > kept_;
  }
  [[nodiscard]] bool hasSegmentBudget() const noexcept { return segments_ > 0 && !isSpent(); }
  /// Then what was last asked is not known.
  [[nodiscard]] bool isSpent() const noexcept { return work_.allowance.isSpent(); }

  /// In the body that it is the deepest in, else behind the first sheet on the segment to it; where a surface has passed over
  /// the IHIP, behind the first surface on that segment, else in the deepest one. Depth 0 when there is none.
  [[nodiscard]] Depth deepest(Vec3 at) noexcept {
    Depth deepest;
    if (isPassed_) deepest = depthBehind(at, Surfaces::kAll);
    if (deepest.depth_m > 0) return deepest;
    spendOnSpheres();
    for (const Body& body : bodies_) {
      if (!isClosed(body) || !withinSphere(body, at) || !hasQueryBudget() || winding(body, at) <= 0) continue;
      const Depth depth = depthIn(body, at);
      if (depth.depth_m > deepest.depth_m) deepest = depth;
    }
    return deepest.depth_m > 0 || isPassed_ ? deepest : depthBehind(at, Surfaces::kSheets);
  }

  /// Fraction of the segment to a place outside of all bodies at which it leaves the last one that encloses `at`; 0
  /// when none does.
  [[nodiscard]] double timeOutside(Vec3 at, Vec3 to) noexcept {
    double time = 0;
    spendOnSpheres();
    for (const Body& body : bodies_) {
      if (!isClosed(body) || !withinSphere(body, at)) continue;
      const int around = winding(body, at);
      if (around <= 0) continue;
      countSegment();
      time = std::max(time,
                      leavesAt(*body.surface, around, body.frame.toLocal(at), body.frame.toLocal(to), work_.allowance));
    }
    return time;
  }

  /// Is it behind no sheet that is near?
  [[nodiscard]] bool isOnContactSide(Vec3 at) noexcept { return depthBehind(at, Surfaces::kSheets).depth_m == 0; }
  /// Is it behind nothing that is near?
  [[nodiscard]] bool isInSight(Vec3 at) noexcept { return depthBehind(at, Surfaces::kAll).depth_m == 0; }
  /// Sets isPassed(): a surface has passed over the IHIP, which is at `from`. Then places are looked for that no surface lies
  /// before.
  void checkWhetherPassed(Vec3 from) noexcept { isPassed_ = !isInSight(from); }
  [[nodiscard]] bool isPassed() const noexcept { return isPassed_; }

  /// Fraction of the segment from a place outside of all bodies at which it enters one, 1 when it does not; whatever
  /// the budget.
  [[nodiscard]] double clearTime(Vec3 from, Vec3 to) noexcept {
    double time = 1;
    for (const Body& body : bodies_) {
      if (body.pendingRemoval) continue;
      countSegment();
      const Crossing crossing =
          body.surface->firstCrossing(body.frame.toLocal(from), body.frame.toLocal(to), work_.allowance);
      if (crossing) time = std::min(time, crossing.time);
    }
    return time;
  }

  /// Distance from the place beyond which there is no body.
  [[nodiscard]] double reachFrom(Vec3 place) const noexcept {
    double reach = 0;
    for (const Body& body : bodies_) {
      if (!body.pendingRemoval) reach = std::max(reach, glm::distance(place, body.centre) + body.surface->radius_m());
    }
    return reach;
  }

 private:
  enum class Surfaces { kAll, kSheets };

  static bool isClosed(const Body& body) noexcept { return !body.pendingRemoval && body.surface->closed(); }

  void spendOnSpheres() noexcept {
    work_.allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies_.size()));
  }
  void countSegment() noexcept {
    --segments_;
    ++work_.segments;
  }

  int winding(const Body& body, Vec3 at) noexcept {
    countSegment();
    return windingNumber(*body.surface, body.frame.toLocal(at), work_.allowance);
  }

  Depth depthBehind(Vec3 at, Surfaces surfaces) noexcept {
    Depth first;
    double time = 1;
    for (int i = 0; i < near_.count(); ++i) {
      const NearBodies::Near& near = near_[i];
      if (near.pendingRemoval || (surfaces == Surfaces::kSheets && near.surface->closed())) continue;
      const Vec3 to = near.frame.toLocal(at);
      if (near.from == to) continue;
      const double reach = near.surface->radius_m() + glm::distance(near.from, to);
      if (squaredLength(to - near.surface->centre()) > reach * reach) continue;
      countSegment();
      const Crossing crossing = near.surface->firstCrossing(near.from, to, work_.allowance);
      if (!crossing || (crossing.time >= time && first.depth_m > 0)) continue;
      time = crossing.time;
      const Vec3 normal = near.surface->faceNormal(crossing.triangle) * static_cast<double>(crossing.side);
      const Vec3 foot = glm::mix(near.from, to, time);
      // also for a point on the surface itself
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
    SearchRun run{.budget = searchBudget(work_.allowance, work_.triangles)};
    foot = neighborhoodWatch(s, foot.triangle, local, run).foot;
    triangles_ -= looked + run.looked;
    work_.triangles += looked + run.looked;
    work_.allowance.spend(Allowance::kNearTriangle * run.looked);
    return {std::sqrt(foot.squaredDistance), body.frame.toWorld(foot.point), body.frame.rotate(s.normal(foot))};
  }

  std::span<const Body> bodies_;
  const NearBodies& near_;
  ContactWork& work_;
  std::int64_t kept_;
  int triangles_ = kMaxDepenetrationTriangles;
  int segments_ = kMaxDepenetrationSegments;
  bool isPassed_ = false;
};

/// The nearest place above the planes of all bodies in the way, met one after the other. None when they leave no room,
/// or when the budget is spent.
std::optional<Vec3> abovePlanes(DepenetrationQuery& query, Vec3 from, double skin) noexcept {
  PlaneSet planes;
  Vec3 at = from;
  while (query.hasQueryBudget()) {
    const Depth inside = query.deepest(at);
    if (inside.depth_m == 0) return query.hasQueryBudget() ? std::optional(at) : std::nullopt;
    if (planes.full()) return std::nullopt;
    planes.add({inside.normal, glm::dot(inside.normal, inside.foot) + skin, {}});
    const auto nearest = planes.nearest(from, skin / 4);
    if (!nearest) return std::nullopt;
    at = nearest->point;
  }
  return std::nullopt;
}

/// The nearest place of those in fifteen directions: out of the bodies that enclose `from`, then out of those that
/// enclose the place there. None when the allowance is spent before one is known.
std::optional<Vec3> throughBodies(DepenetrationQuery& query, Vec3 from, Vec3 outward, double skin) noexcept {
  constexpr double kThird = 0.57735026918962576;  // root of
  std::array<Vec3, 15> directions{outward, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (std::size_t i = 0; i < 8; ++i) {
    directions[7 + i] = Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1) * kThird;
  }
  const double reach = query.reachFrom(from) + skin;
  double nearest = reach, nearestInSight = reach;
  Vec3 place = from, placeInSight = from;
  for (const Vec3 direction : directions) {
    if (direction == Vec3(0)) continue;
    const Vec3 beyond = from + direction * reach;
    double distance = 0;
    while (distance < (query.isPassed() ? nearestInSight : nearest) && query.hasSegmentBudget()) {
      const Vec3 at = from + direction * distance;
      const double out = query.timeOutside(at, beyond);
      if (out > 0) {
        distance += out * (reach - distance) + skin;
        continue;
      }
      const bool isInSight = query.isPassed() && query.isInSight(at);
      const bool isOut = isInSight || (distance < nearest && query.isOnContactSide(at));
      if (query.isSpent()) break;
      if (isInSight) {
        nearestInSight = distance;
        placeInSight = at;
      } else if (isOut) {
        nearest = distance;
        place = at;
      }
      break;
    }
  }
  if (nearestInSight < reach) return placeInSight;
  if (query.isSpent() && (query.isPassed() || nearest == reach)) return std::nullopt;
  if (nearest < reach) return place;
  Vec3 farDirection = outward == Vec3(0) ? directions[1] : outward;
  for (const Vec3 direction : directions) {
    if (direction == Vec3(0) || !query.isOnContactSide(from + direction * reach)) continue;
    farDirection = direction;
    break;
  }
  const Vec3 beyond = from + farDirection * reach;
  const double clear = query.clearTime(beyond, from);
  if (query.isSpent()) return std::nullopt;
  return glm::mix(beyond, from, clear * (1 - skin / reach));
}

}  // namespace

std::optional<Vec3> findDepenetration(std::span<const Body> bodies, const NearBodies& near, Vec3 from, Vec3 outward,
                                      double skin, ContactWork& work) noexcept {
  DepenetrationQuery query(bodies, near, work);
  query.checkWhetherPassed(from);
  const auto open = abovePlanes(query, from, skin);
  const bool isOpen =
      open && glm::distance(*open, from) <= query.reachFrom(from) + skin;  // not so between nearly parallel planes
  return isOpen ? open : throughBodies(query, from, outward, skin);
}

}  // namespace haptics
