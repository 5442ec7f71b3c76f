#include "haptic_server/engine/collision/near_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_server/engine/collision/polytope_on_mesh.h"
#include "haptic_server/engine/collision/surface_queries.h"
#include "haptic_server/engine/contact/frame.h"

namespace haptics {

using namespace surface_queries;

namespace {

/// A point within the others' area is taken, too, where it is deeper by so much, m.
constexpr double kDeeper_m = 1e-6;
constexpr double kStill_m_per_s = 1e-5;

[[nodiscard]] bool isSurelyBehind(const CollisionMesh& surface, const ClosestPoint& foot, Vec3 at) noexcept {
  return foot.triangle != kNoTriangle &&
         glm::dot(surface.faceNormal(foot.triangle), at - foot.point) < -kSurelyBehind_m;
}

[[nodiscard]] bool isNear(const CollisionMesh& surface, Vec3 at, double range_m, std::uint32_t& hint,
                          Allowance& allowance) noexcept {
  const double squared = range_m * range_m;
  allowance.spend(Allowance::kNearTriangle);
  if (hint != kNoTriangle && closestOn(surface.triangle(hint), hint, at).squaredDistance <= squared) return true;
  bool near = false;
  allowance.spend(kQuery);
  surface.hierarchy().visitNear(
      at, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::uint32_t t = begin; t < end && !near; ++t) {
          if (isBoxFarther(surface.triangle(t), at, squared, allowance)) continue;
          allowance.spend(Allowance::kNearTriangle);
          near = closestOn(surface.triangle(t), t, at).squaredDistance <= squared;
          if (near) hint = t;
        }
        return near ? -1 : squared;
      },
      squared);
  return near;
}

/// @param normal  Of any length.
[[nodiscard]] bool faces(Vec3 normal, Vec3 out) noexcept {
  constexpr double kAgainst = 0.1;  // cosine; 0 would let rounding decide about faces at right angles
  const double along = glm::dot(normal, out);
  return along < 0 && along * along > kAgainst * kAgainst * squaredLength(normal);
}

struct Feet {
  ClosestPoint met;      ///< The closest place of those faces that a body may meet there: they look the other way.
  ClosestPoint nearest;  ///< Of all faces, where `met` is.
};
/// @param out  The normal that the body has there.
/// @param isOutside  Then what is behind a face does not meet it.
[[nodiscard]] Feet feetWithin(const CollisionMesh& surface, Vec3 at, Vec3 out, double range_m, bool isOutside,
                              std::uint32_t& hint, Allowance& allowance) noexcept {
  Feet feet;
  feet.met.squaredDistance = feet.nearest.squaredDistance = range_m * range_m;
  const auto look = [&](std::uint32_t t) noexcept {
    const TriangleRecord& triangle = surface.triangle(t);
    if (isFarther(triangle, at, feet.met.squaredDistance, allowance)) return;
    const ClosestPoint point = closestOn(triangle, t, at);
    if (point.squaredDistance < feet.nearest.squaredDistance) feet.nearest = point;
    if (point.squaredDistance >= feet.met.squaredDistance || !faces(triangle.areaNormal(), out)) return;
    if (!isOutside || !isSurelyBehind(surface, point, at)) feet.met = point;
  };
  if (hint != kNoTriangle) look(hint);
  visit(surface, at, feet.met, look, allowance);
  if (feet.met.triangle != kNoTriangle) hint = feet.met.triangle;
  return feet;
}
/// Roughly, of the body at a contact's point; in the frame of the surface that it meets.
/// @param pose  Of the body in that frame.
[[nodiscard]] Vec3 outOf(const CollisionPoints& points, const BodyContact& contact, const Pose& pose) noexcept {
  if (contact.point < points.points.size()) return pose.rotation * points.points[contact.point].normal;
  return points.polytope ? pose.rotation * unitOrZero(contact.place - points.polytope->middle) : -contact.normal;
}

/// The nearest place of a face that the body's point is level with, and that the contact's plane stops it from getting onto.
[[nodiscard]] ClosestPoint levelWith(const CollisionMesh& surface, Vec3 at, Vec3 out, const BodyContact& contact,
                                     double step_m, Allowance& allowance) noexcept {
  ClosestPoint level;
  const double reach_m = glm::distance(at, contact.foot) + step_m;
  level.squaredDistance = reach_m * reach_m;
  const auto look = [&](std::uint32_t t) noexcept {
    const TriangleRecord& triangle = surface.triangle(t);
    if (isFarther(triangle, at, step_m * step_m, allowance) || !faces(triangle.areaNormal(), out)) return;
    if (glm::dot(surface.faceNormal(t), contact.normal) > kSameSide) return;
    const ClosestPoint point = closestOn(triangle, t, at);
    if (point.squaredDistance < level.squaredDistance) level = point;
  };
  allowance.spend(kQuery);
  surface.hierarchy().visitBox(Vec3f(at - Vec3(reach_m)), Vec3f(at + Vec3(reach_m)), allowance,
                               [&](std::uint32_t begin, std::uint32_t end) noexcept {
                                 for (std::uint32_t t = begin; t < end; ++t) look(t);
                               });
  return level;
}

/// False: the point is beside the face, where another one is met.
[[nodiscard]] bool nearAt(const CollisionPoints& points, std::uint32_t point, const CollisionMesh& surface, Vec3 at,
                          Vec3 out, const ClosestPoint& foot, const Pose& pose, bool ofSecond,
                          NearPoint& near) noexcept {
  const double distance = std::sqrt(foot.squaredDistance);
  Vec3 normal = surface.faceNormal(foot.triangle);
  const double height = glm::dot(normal, at - foot.point);
  double gap = height;
  constexpr double kRounding = 1e-9;  // m: nearer ones have no direction
  const bool beside = squaredLength(at - foot.point - height * normal) > kRounding * kRounding;
  if (beside && height < 0) return false;
  if (beside) {
    normal = (at - foot.point) / distance;
    gap = distance;
    if (!faces(normal, out)) return false;
  }
  near.contact = {point, ofSecond ? 1U : 0U, points.points[point].place, foot.point, normal, Vec3(0)};
  near.gap_m = gap;
  const Pose back = inverse(pose);
  near.at = ofSecond ? toWorld(back, at) : at;
  near.normal = ofSecond ? back.rotation * -normal : normal;
  return true;
}

/// With what it was given in the last tick.
void take(const BodyContact& contact, const BodyPair& before, BodyPair& pair) noexcept {
  if (pair.contacts.count == kPointsOfPair) return;
  BodyContact& taken = pair.contacts[pair.contacts.count++];
  taken = contact;
  for (const BodyContact& was : before.contacts.all()) {
    if (was.point == contact.point && was.second == contact.second) taken.impulse_Ns = was.impulse_Ns;
  }
}

}  // namespace

bool NearPoints::find(const CollisionPoints& points, const CollisionMesh& surface, const Pose& pose, bool ofSecond,
                      Allowance& allowance) noexcept {
  const Frame frame(pose);
  const Vec3 middle = surface.centre();
  std::uint32_t hint = kNoTriangle;  // one that was near
  std::uint64_t& n = search_.node;
  while (n < points.nodes.size()) {
    const CollisionPoints::Node& node = points.nodes[n];
    const std::uint64_t found = search_.near.count;
    const Vec3 centre = frame.toWorld(node.centre);
    const double bound = surface.radius_m() + node.radius_m + std::max(search_.range_m, search_.depth_m);
    Allowance left = mayExceed_ ? Allowance(std::max(allowance.left(), kOneNode)) : allowance;
    const std::int64_t before = left.left();
    left.spend(Allowance::kSphere);
    const bool near = squaredLength(centre - middle) <= bound * bound &&
                      (isNear(surface, centre, node.radius_m + farthest(), hint, left) ||
                       (isDeep() && isInside(surface, centre, node.radius_m + search_.depth_m, left)));
    const bool isLeaf = node.next == n + 1;
    for (std::uint32_t p = node.begin; near && isLeaf && p < node.end; ++p)
      add(points, p, surface, frame, pose, ofSecond, hint, left);
    allowance.spend(before - left.left());
    if (left.isSpent()) {
      search_.near.count = found;
      if (!mayExceed_) return false;  // what it holds is left out, or nothing would ever go on
    }
    mayExceed_ = false;
    n = near ? n + 1 : node.next;
  }
  n = 0;
  return true;
}

void NearPoints::lowerClearance(const CollisionMesh& smaller, const CollisionMesh& other, const Pose& pose,
                                Allowance& allowance) noexcept {
  const Vec3 centre = toWorld(pose, smaller.centre());
  const ClosestPoint nearest = nearestWithin(other, centre, smaller.radius_m() + search_.clear_m, allowance);
  const bool isHeld = isDeep() && isInside(other, centre, nearest, allowance);
  const double distance_m = isHeld || allowance.isSpent() ? 0 : std::sqrt(nearest.squaredDistance);
  search_.clear_m = std::max(distance_m - smaller.radius_m(), search_.range_m);
}

bool NearPoints::findOn(const Collider& solid, const Collider& ground, const Pose& pose, bool solidIsFirst,
                        double step_m, double period_s, BodyPair& pair, Allowance& allowance) noexcept {
  if (isDeep()) return false;
  Allowance queries(std::max(kOneNode, allowance.left()));  // what runs out of it says nothing
  const std::int64_t before = queries.left();
  ManyNear near;
  near.count = 0;
  const Quat back = glm::conjugate(ground.pose.rotation);
  const Vec3 origin = ground.pose.position;
  NearRange reach{farthest(),
                  period_s,
                  {search_.range_m, step_m, back * (solid.velocityBefore(origin) - ground.velocityBefore(origin)),
                   back * (solid.before.angular - ground.before.angular)}};
  const bool found = findOnMesh(solid, ground, pose, solidIsFirst, reach, near, queries) && !queries.isSpent();
  allowance.spend(before - queries.left());
  if (found) choose(near.all(), pair);
  isOneOfTwo_ = found && reach.isOneOfTwo;
  return found;
}

void NearPoints::choose(std::span<NearPoint> near, BodyPair& pair) const noexcept {
  struct Side {
    std::span<const NearPoint> near;
    Vec3 normal;
    double depth_m;
  };
  std::array<Side, kPointsOfPair> sides;
  std::size_t count = 0;
  double shortest = std::numeric_limits<double>::infinity();
  for (auto left = near; !left.empty() && count < sides.size();) {
    const NearPoint deepest = *std::ranges::min_element(left, {}, &NearPoint::gap_m);
    const auto rest = std::partition(
        left.begin(), left.end(), [&](const NearPoint& n) { return glm::dot(n.normal, deepest.normal) > kSameSide; });
    const auto own = static_cast<std::size_t>(rest - left.begin());
    sides[count++] = {left.first(own), deepest.normal, -deepest.gap_m};
    if (deepest.gap_m < 0) shortest = std::min(shortest, -deepest.gap_m);
    left = left.subspan(own);
  }
  const BodyPair before = pair;
  pair.contacts.count = 0;
  pair.depth_m = 0;
  for (const Side& side : std::span(sides).first(count)) {
    if (side.depth_m > shortest + search_.range_m) continue;
    pair.depth_m = std::max(pair.depth_m, side.depth_m);
    chooseOf(side.near, side.normal, before, pair);
  }
}

void NearPoints::chooseOf(std::span<const NearPoint> near, Vec3 normal, const BodyPair& before,
                          BodyPair& pair) noexcept {
  Vec3 mean(0);
  for (const NearPoint& n : near) mean += n.at / static_cast<double>(near.size());
  const auto farthestFrom = [&](Vec3 place) {
    return std::ranges::max_element(near, {}, [&](const NearPoint& n) { return squaredLength(n.at - place); });
  };
  const auto a = farthestFrom(mean), b = farthestFrom(a->at);
  const Vec3 across = glm::cross(normal, b->at - a->at);
  const auto aside = [&](const NearPoint& n) { return glm::dot(across, n.at - a->at); };
  const auto [right, left] = std::ranges::minmax_element(near, {}, aside);
  const auto deepest = std::ranges::min_element(near, {}, &NearPoint::gap_m);
  const double least = 1e-6 * squaredLength(across);  // beside the line by more than rounding
  double gap = a->gap_m;
  const auto add = [&](auto which) {
    gap = std::min(gap, which->gap_m);
    take(which->contact, before, pair);
  };
  add(a);
  if (b != a) add(b);
  if (aside(*left) > least) add(left);
  if (aside(*right) < -least) add(right);
  if (deepest->gap_m < gap - kDeeper_m) add(deepest);
}

void NearPoints::passSteps(const Collider& first, const Collider& second, const Pose& relative, double step_m,
                           BodyPair& pair, Allowance& allowance) noexcept {
  const Pose back = inverse(relative);
  std::uint64_t kept = 0;
  for (BodyContact& contact : pair.contacts.all()) {
    const bool reverse = contact.second != 0;
    const Collider &on = reverse ? second : first, &under = reverse ? first : second;
    const Pose& pose = reverse ? back : relative;
    const Vec3 at = toWorld(pose, contact.place);
    const Vec3 out = outOf(*on.points, contact, pose);
    const CollisionMesh& surface = *under.surface;
    const ClosestPoint level = levelWith(surface, at, out, contact, step_m, allowance);
    if (level.triangle != kNoTriangle) {
      const Vec3 normal = surface.faceNormal(level.triangle);
      const Vec3 place = toWorld(on.pose, contact.place);
      const Vec3 velocity =
          glm::conjugate(under.pose.rotation) * (on.velocityBefore(place) - under.velocityBefore(place));
      const double toTop = -glm::dot(normal, velocity), toSide = -glm::dot(contact.normal, velocity);
      const bool rests = glm::dot(normal, at - level.point) < 0 && glm::dot(contact.normal, at - contact.foot) > 0;
      const bool passes = std::abs(toSide - toTop) > kStill_m_per_s ? toTop < toSide : rests;
      if (passes && level.squaredDistance > step_m * step_m) continue;
      if (passes) {
        contact.foot = level.point;
        contact.normal = normal;
      }
    }
    pair.contacts[kept++] = contact;
  }
  pair.contacts.count = kept;
}

void NearPoints::add(const CollisionPoints& points, std::uint32_t point, const CollisionMesh& surface,
                     const Frame& frame, const Pose& pose, bool ofSecond, std::uint32_t& hint,
                     Allowance& allowance) noexcept {
  const Vec3 at = frame.toWorld(points.points[point].place), out = frame.rotate(points.points[point].normal);
  Feet feet = feetWithin(surface, at, out, farthest(), false, hint, allowance);
  if (feet.met.triangle == kNoTriangle && isDeep() && isInside(surface, at, search_.depth_m, allowance))
    feet = feetWithin(surface, at, out, search_.depth_m, false, hint, allowance);
  else if (isSurelyBehind(surface, feet.met, at) && !isInside(surface, at, feet.nearest, allowance))
    feet = feetWithin(surface, at, out, search_.range_m, true, hint, allowance);
  if (feet.met.triangle == kNoTriangle || search_.near.count == search_.near.capacity()) return;
  NearPoint& near = search_.near[search_.near.count];
  if (nearAt(points, point, surface, at, out, feet.met, pose, ofSecond, near) && near.gap_m <= search_.range_m)
    ++search_.near.count;
}

}  // namespace haptics
