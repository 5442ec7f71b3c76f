#include "haptic_server/engine/collision/body_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "haptic_server/engine/contact/frame.h"
#include "haptic_server/engine/geometry/enclosure.h"

namespace haptics {
namespace {

/// Points are looked for anew once a body has moved so far against the other, of the smaller one's radius. Smaller looks
/// more often; larger lets round bodies roll on points that are no longer the lowest.
constexpr double kStaleAfter = 0.01;
/// Likewise of two polytopes, which costs less.
constexpr double kPolytopesStaleAfter = 0.001;
/// A range lasts for so many ticks but one, unless bodies are faster than it is worth.
constexpr double kTicksOfRange = 4;
/// A search that takes more than a tick begins so many ticks before the range ends.
constexpr double kTicksAhead = 3;
/// Units (Allowance) of beginning a search that ranks nothing.
constexpr std::int64_t kQuery = 64;
/// Units of the distance from a triangle's plane, and from its box.
constexpr std::int64_t kPlane = 24, kBox = 12;
/// More than rounding may do.
constexpr double kSurelyFarther = 1 + 0x1p-30;
/// What the four points of a leaf may take in the worst case.
constexpr std::int64_t kOneNode = 60'000;
/// Normals are much the same where their cosine is larger.
constexpr double kSameSide = 0.9;
/// A point within the others' area is taken, too, where it is deeper by so much, m.
constexpr double kDeeper_m = 1e-6;
/// Steps that bodies are lifted over rather than stopped by, of the smaller one's radius, and m. Flush bodies have such ones:
/// what rests on them is up to 20 um deep in each.
constexpr double kStep = 0.003, kLowestStep_m = 10e-6, kHighestStep_m = 50e-6;
constexpr double kStill_m_per_s = 1e-5;
/// A point that is so deep behind a face is looked for inside, m: at less than that rounding decides.
constexpr double kSurelyBehind_m = 1e-6;

/// A body and what the search needs of it.
struct Moving {
  Vec3 centre;  // of the sphere, world
  double radius_m;
  Vec3 velocity;    // of its pivot()
  double spin_m_s;  // of the farthest point about it

  explicit Moving(const Collider& body) noexcept
      : centre(toWorld(body.pose, body.surface->centre())),
        radius_m(body.surface->radius_m()),
        velocity(0),
        spin_m_s(0) {
    if (!isAwake(body) && !body.isDriven) return;
    const RigidVelocity v = body.isDriven ? body.before : velocityOf(*body.rigidBody, *body.state);
    velocity = v.linear;
    spin_m_s = glm::length(v.angular) * (radius_m + glm::distance(centre, body.pivot()));
  }
  Moving() = default;
};

/// How far two bodies get against each other in a tick, at most; m.
[[nodiscard]] double reachOf(const Moving& a, const Moving& b, double period_s) noexcept {
  return period_s * (glm::distance(a.velocity, b.velocity) + a.spin_m_s + b.spin_m_s);
}

/// The places of pairs by their bodies.
class PlaceTable {
 public:
  explicit PlaceTable(const BodyPairs& pairs) noexcept {
    for (std::size_t i = 0; i < pairs.places.count; ++i) {
      const BodyPair& pair = pairs.places[i];
      if (pair.used != 0) slot(pair.first, pair.second) = static_cast<std::uint8_t>(i + 1);
    }
  }
  /// 0: it has none; else one more than it.
  [[nodiscard]] std::uint8_t& slot(std::size_t first, std::size_t second) noexcept {
    std::size_t at = (first * 31 + second) % kSize;
    while (place_[at] != 0 && key_[at] != keyOf(first, second)) at = at + 1 == kSize ? 0 : at + 1;
    key_[at] = keyOf(first, second);
    return place_[at];
  }

 private:
  static constexpr std::size_t kSize = 509;  // prime, and more than twice kMaxPairs
  std::array<std::uint8_t, kSize> place_{};
  std::array<std::uint32_t, kSize> key_;

  [[nodiscard]] static std::uint32_t keyOf(std::size_t first, std::size_t second) noexcept {
    return static_cast<std::uint32_t>(first << 16U | second);
  }
};
static_assert(kMaxPairs < 255);

[[nodiscard]] Pose relativePose(const Pose& first, const Pose& second) noexcept {
  const Quat back = glm::conjugate(second.rotation);
  return {glm::normalize(back * first.rotation), back * (first.position - second.position)};
}

[[nodiscard]] Pose inverse(const Pose& pose) noexcept {
  const Quat back = glm::conjugate(pose.rotation);
  return {back, back * -pose.position};
}

/// How far any place within `extent_m` of the first body's origin has moved against the second.
[[nodiscard]] double movedBy(const Pose& was, const Pose& is, double extent_m) noexcept {
  const Quat turn = is.rotation * glm::conjugate(was.rotation);
  return glm::distance(was.position, is.position) + 2 * extent_m * glm::length(Vec3(turn.x, turn.y, turn.z));
}

/// Finds the points of two bodies that are near each other's surfaces, in as many ticks as it takes.
class NearPoints {
 public:
  /// @param mayExceed  The first node is searched whatever it takes up to kOneNode: each tick gets on.
  NearPoints(PairSearch& search, bool mayExceed) noexcept : search_(search), mayExceed_(mayExceed) {}

  /// @param pose  Of the points' body in the surface's frame.
  /// @return False: the allowance is spent on the way.
  [[nodiscard]] bool find(const CollisionPoints& points, const CollisionMesh& surface, const Pose& pose, bool ofSecond,
                          Allowance& allowance) noexcept {
    const Frame frame(pose);
    const Vec3 middle = surface.centre();
    std::uint32_t hint = kNoTriangle;  // one that was near
    std::uint64_t& n = search_.node;
    while (n < points.nodes.size()) {
      const CollisionPoints::Node& node = points.nodes[n];
      const std::uint64_t found = search_.near.count;
      const Vec3 centre = frame.toWorld(node.centre);
      const double bound = surface.radius_m() + node.radius_m + std::max(search_.clear_m, search_.depth_m);
      Allowance left = mayExceed_ ? Allowance(std::max(allowance.left(), kOneNode)) : allowance;
      const std::int64_t before = left.left();
      left.spend(Allowance::kSphere);
      const bool near = squaredLength(centre - middle) <= bound * bound &&
                        (isNear(surface, centre, node.radius_m + std::max(search_.clear_m, farthest()), hint, left) ||
                         (isDeep() && isInside(surface, centre, node.radius_m + search_.depth_m, left)));
      const bool isLeaf = node.next == n + 1;
      for (std::uint32_t p = node.begin; near && isLeaf && p < node.end; ++p)
        add(points, p, surface, frame, pose, ofSecond, hint, left);
      allowance.spend(before - left.left());
      if (left.isSpent()) {
        search_.near.count = found;
        if (!mayExceed_) return false;
        search_.clear_m = search_.range_m;  // what it holds is left out, or nothing would ever go on
      }
      mayExceed_ = false;
      n = near ? n + 1 : node.next;
    }
    n = 0;
    return true;
  }

  /// Of points whose normals are much the same those that span the largest area, and the deepest one. Where bodies are deep in
  /// each other, only the shortest way out counts.
  void choose(BodyPair& pair) noexcept {
    struct Side {
      std::span<const NearPoint> near;
      Vec3 normal;
      double depth_m;
    };
    std::array<Side, kPointsOfPair> sides;
    std::size_t count = 0;
    double shortest = std::numeric_limits<double>::infinity();
    for (auto left = search_.near.all(); !left.empty() && count < sides.size();) {
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

  /// Of all points at once, where they are on one side. `near` is not empty.
  static void chooseOf(std::span<const NearPoint> near, Vec3 normal, const BodyPair& before, BodyPair& pair) noexcept {
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

  /// Has bodies go over what is no step: a contact with the side of something whose top the point is level with, and that it
  /// comes to by the side, is left out, or is one with the top where the point has got there.
  static void passSteps(const Collider& first, const Collider& second, const Pose& relative, double step_m,
                        BodyPair& pair, Allowance& allowance) noexcept {
    const Pose back = inverse(relative);
    std::uint64_t kept = 0;
    for (BodyContact& contact : pair.contacts.all()) {
      const bool reverse = contact.second != 0;
      const Collider &on = reverse ? second : first, &under = reverse ? first : second;
      const Pose& pose = reverse ? back : relative;
      const Vec3 at = toWorld(pose, contact.place);
      const Vec3 out = pose.rotation * on.points->points[contact.point].normal;
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

 private:
  PairSearch& search_;
  bool mayExceed_;

  /// The bodies may overlap, as an edit has put one of them there.
  [[nodiscard]] bool isDeep() const noexcept { return search_.depth_m > 2 * search_.range_m; }
  /// How far from a face a point may meet it, unless it is deep inside.
  [[nodiscard]] double farthest() const noexcept {
    return isDeep() ? search_.range_m : std::max(search_.range_m, search_.depth_m);
  }

  void add(const CollisionPoints& points, std::uint32_t point, const CollisionMesh& surface, const Frame& frame,
           const Pose& pose, bool ofSecond, std::uint32_t& hint, Allowance& allowance) noexcept {
    const Vec3 at = frame.toWorld(points.points[point].place), out = frame.rotate(points.points[point].normal);
    if (search_.clear_m > search_.range_m) lowerClearance(surface, at, hint, allowance);
    if (search_.clear_m > search_.range_m) return;
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

  [[nodiscard]] static bool isSurelyBehind(const CollisionMesh& surface, const ClosestPoint& foot, Vec3 at) noexcept {
    return foot.triangle != kNoTriangle &&
           glm::dot(surface.faceNormal(foot.triangle), at - foot.point) < -kSurelyBehind_m;
  }

  /// Behind a face is not inside: a plate's far face has all that lies above the plate behind it.
  [[nodiscard]] static bool isInside(const CollisionMesh& surface, Vec3 at, const ClosestPoint& nearest,
                                     Allowance& allowance) noexcept {
    if (surface.closed() && surface.anySelfIntersecting()) return windingNumber(surface, at, allowance) > 0;
    return nearest.triangle != kNoTriangle && !surface.isOutside(nearest, at);
  }
  /// And no deeper than that.
  [[nodiscard]] static bool isInside(const CollisionMesh& surface, Vec3 at, double depth_m,
                                     Allowance& allowance) noexcept {
    ClosestPoint nearest;
    nearest.squaredDistance = depth_m * depth_m;
    const auto look = [&](std::uint32_t t) noexcept {
      if (isFarther(surface.triangle(t), at, nearest.squaredDistance, allowance)) return;
      const ClosestPoint point = closestOn(surface.triangle(t), t, at);
      if (point.squaredDistance < nearest.squaredDistance) nearest = point;
    };
    visit(surface, at, nearest, look, allowance);
    return isInside(surface, at, nearest, allowance);
  }

  /// Shows each triangle that may be nearer than `nearest`.
  template <class Look>
  static void visit(const CollisionMesh& surface, Vec3 at, const ClosestPoint& nearest, Look look,
                    Allowance& allowance) noexcept {
    allowance.spend(kQuery);
    surface.hierarchy().visitNear(
        at, allowance,
        [&](std::uint32_t begin, std::uint32_t end) noexcept {
          for (std::uint32_t t = begin; t < end; ++t) look(t);
          return nearest.squaredDistance;
        },
        nearest.squaredDistance);
  }

  /// Its plane is no nearer. Else what the closest point costs is spent.
  [[nodiscard]] static bool isFarther(const TriangleRecord& triangle, Vec3 at, double squared,
                                      Allowance& allowance) noexcept {
    constexpr double kAsFar = 1 - 0x1p-30;  // in the same plane is not nearer
    const Vec3 normal = triangle.areaNormal();
    const double height = glm::dot(normal, at - triangle.corner(0));
    const bool farther = height * height > kAsFar * squared * squaredLength(normal);
    allowance.spend(farther ? kPlane : kPlane + Allowance::kNearTriangle);
    return farther;
  }

  /// The box about it is. Else what the closest point costs is spent.
  [[nodiscard]] static bool isBoxFarther(const TriangleRecord& triangle, Vec3 at, double squared,
                                         Allowance& allowance) noexcept {
    const auto& rows = triangle.rows;
    Vec3 gap;
    for (int d = 0; d < 3; ++d) {
      const auto& [a, b, c, neighbour] = rows[static_cast<std::size_t>(d)];
      gap[d] = std::max({std::min({a, b, c}) - at[d], at[d] - std::max({a, b, c}), 0.0});
    }
    const bool farther = squaredLength(gap) > kSurelyFarther * squared;
    allowance.spend(farther ? kBox : kBox + Allowance::kNearTriangle);
    return farther;
  }

  /// To the place's distance from the surface where that is less, and not below range_m.
  void lowerClearance(const CollisionMesh& surface, Vec3 at, std::uint32_t& hint, Allowance& allowance) noexcept {
    double squared = search_.clear_m * search_.clear_m;
    allowance.spend(kQuery);
    surface.hierarchy().visitNear(
        at, allowance,
        [&](std::uint32_t begin, std::uint32_t end) noexcept {
          for (std::uint32_t t = begin; t < end; ++t) {
            if (isBoxFarther(surface.triangle(t), at, squared, allowance)) continue;
            const double here = closestOn(surface.triangle(t), t, at).squaredDistance;
            if (here >= squared) continue;
            squared = here;
            hint = t;
          }
          return squared;
        },
        squared);
    search_.clear_m = std::max(std::sqrt(squared), search_.range_m);
  }

  [[nodiscard]] static bool isNear(const CollisionMesh& surface, Vec3 at, double range_m, std::uint32_t& hint,
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
            near = closestOn(surface.triangle(t), t, at).squaredDistance <= squared;
            if (near) hint = t;
          }
          return near ? -1 : squared;
        },
        squared);
    return near;
  }

  struct Feet {
    ClosestPoint met;      ///< The closest place of those faces that a body may meet there: they look the other way.
    ClosestPoint nearest;  ///< Of all faces, where `met` is.
  };
  /// @param out  The normal that the body has there.
  /// @param isOutside  Then what is behind a face does not meet it.
  [[nodiscard]] static Feet feetWithin(const CollisionMesh& surface, Vec3 at, Vec3 out, double range_m, bool isOutside,
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
  /// @param normal  Of any length.
  [[nodiscard]] static bool faces(Vec3 normal, Vec3 out) noexcept {
    constexpr double kAgainst = 0.1;  // cosine; 0 would let rounding decide about faces at right angles
    const double along = glm::dot(normal, out);
    return along < 0 && along * along > kAgainst * kAgainst * squaredLength(normal);
  }

  /// The nearest place of a face that the body's point is level with, and that the contact's plane stops it from getting onto.
  [[nodiscard]] static ClosestPoint levelWith(const CollisionMesh& surface, Vec3 at, Vec3 out,
                                              const BodyContact& contact, double step_m,
                                              Allowance& allowance) noexcept {
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
    visit(surface, at, level, look, allowance);
    return level;
  }

  /// False: the point is beside the face, where another one is met.
  [[nodiscard]] static bool nearAt(const CollisionPoints& points, std::uint32_t point, const CollisionMesh& surface,
                                   Vec3 at, Vec3 out, const ClosestPoint& foot, const Pose& pose, bool ofSecond,
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
  static void take(const BodyContact& contact, const BodyPair& before, BodyPair& pair) noexcept {
    if (pair.contacts.count == kPointsOfPair) return;
    BodyContact& taken = pair.contacts[pair.contacts.count++];
    taken = contact;
    for (const BodyContact& was : before.contacts.all()) {
      if (was.point == contact.point && was.second == contact.second) taken.impulse_Ns = was.impulse_Ns;
    }
  }
};

/// Goes on with the search for the contacts of a pair. False: the allowance is spent, and the pair is as it was.
[[nodiscard]] bool look(const Collider& first, const Collider& second, double step_m, PairSearch& search, bool isFirst,
                        BodyPair& pair, Allowance& allowance) noexcept {
  NearPoints near(search, isFirst);
  const std::int64_t before = allowance.left();
  const auto isFound = [&] {
    if (search.reverse == 0) {
      if (!near.find(*first.points, *second.surface, search.relative, false, allowance)) return false;
      search.reverse = 1;
    }
    return near.find(*second.points, *first.surface, inverse(search.relative), true, allowance);
  };
  const bool found = isFound();
  search.units += static_cast<std::uint64_t>(before - allowance.left());
  if (!found) return false;
  near.choose(pair);
  NearPoints::passSteps(first, second, search.relative, step_m, pair, allowance);
  pair.range_m = pair.contacts.count == 0 ? search.clear_m : search.range_m;
  pair.relative = search.relative;
  pair.units = search.units;
  search.pair = 0;
  return true;
}

/// How a pair is in this tick.
struct PairNow {
  PairNow(std::span<const Collider> bodies, std::span<const Moving> moving, const BodyPair& pair,
          double period_s) noexcept
      : first(bodies[pair.first]),
        second(bodies[pair.second]),
        relative(relativePose(first.pose, second.pose)),
        reach_m(reachOf(moving[pair.first], moving[pair.second], period_s)),
        smaller_m(std::min(moving[pair.first].radius_m, moving[pair.second].radius_m)),
        step_m(std::clamp(kStep * smaller_m, kLowestStep_m, kHighestStep_m)) {}

  const Collider &first, &second;
  const Pose relative;
  const double reach_m;    ///< reachOf().
  const double smaller_m;  ///< Radius.
  const double step_m;     ///< That is none.

  /// Since the bodies were so, and in this tick.
  [[nodiscard]] double movedSince(const Pose& was) const noexcept {
    return movedBy(was, relative, first.surface->extent_m()) + reach_m;
  }
  [[nodiscard]] bool isKnown(const BodyPair& pair) const noexcept {
    if (pair.range_m < 0) return false;
    const double moved_m = movedSince(pair.relative);
    const bool isFresh = !arePolytopes() || pair.contacts.count == 0 || moved_m - reach_m <= stale_m();
    return isFresh && moved_m <= pair.range_m;
  }
  /// Of two polytopes.
  [[nodiscard]] double stale_m() const noexcept { return kPolytopesStaleAfter * smaller_m; }
  [[nodiscard]] bool arePolytopes() const noexcept { return first.points->polytope && second.points->polytope; }
  /// Finds the contacts of two polytopes.
  void meet(BodyPair& pair, Allowance& allowance) const noexcept {
    allowance.spend(contactUnits(*first.points->polytope, *second.points->polytope));
    const Quat back = glm::conjugate(second.pose.rotation);
    const auto velocityAt = [&](Vec3 place) {
      return back * (first.velocityBefore(place) - second.velocityBefore(place));
    };
    const PolytopeWay way{reach_m + stale_m(), step_m, velocityAt(second.pose.position),
                          back * (first.before.angular - second.before.angular), pressedAlong(pair)};
    const PolytopeContact found = contactOf(*first.points->polytope, *second.points->polytope, relative, way);
    const BodyPair before = pair;
    pair.contacts.count = 0;
    std::array<NearPoint, std::tuple_size_v<decltype(found.points)>> near;
    const Pose toFirst = inverse(relative);
    for (std::size_t i = 0; i < found.count; ++i) {
      const PolytopeContact::Point& point = found.points[i];
      BodyContact& contact = near[i].contact;
      contact = {point.id, 0, toWorld(toFirst, point.on), point.foot, found.normal, Vec3(0)};
      if (found.ofSecond)
        contact = {point.id, 1, point.on, toWorld(toFirst, point.foot), toFirst.rotation * -found.normal, Vec3(0)};
      near[i].gap_m = point.gap_m;
      near[i].at = point.on;
      near[i].normal = found.normal;
    }
    if (found.count > 0) NearPoints::chooseOf(std::span(near).first(found.count), found.normal, before, pair);
    pair.range_m = found.count > 0 ? way.range_m : std::max(way.range_m, found.gap_m);
    pair.depth_m = std::max(0.0, -found.gap_m);
    pair.relative = relative;
    pair.units = 0;
  }
  /// The normal of the contacts that the last tick pressed, out of the second body in its frame; 0: none.
  [[nodiscard]] Vec3 pressedAlong(const BodyPair& pair) const noexcept {
    if (first.isPut || second.isPut) return Vec3(0);
    for (const BodyContact& contact : pair.contacts.all()) {
      if (contact.impulse_Ns == Vec3(0)) continue;
      return contact.second == 0 ? contact.normal : relative.rotation * -contact.normal;
    }
    return Vec3(0);
  }
  /// Begins a search unless there is one of the pair that will be of use.
  void begin(std::size_t place, const BodyPair& pair, PairSearch& search) const noexcept {
    if (search.pair == place + 1 && movedSince(search.relative) <= search.range_m) return;
    const double stale = kStaleAfter * smaller_m;
    const double range_m = std::max(reach_m, std::clamp(kTicksOfRange * reach_m, stale, kTicksOfRange * stale));
    const bool isApart = pair.contacts.count == 0 && pair.depth_m == 0;
    const double clear_m = isApart ? std::max(range_m, smaller_m) : range_m;
    search.begin(place, relative, range_m, range_m + pair.depth_m, clear_m);
  }
};

using AllMoving = std::array<Moving, kMaxColliders>;
void describe(std::span<const Collider> bodies, AllMoving& moving) noexcept {
  for (std::size_t i = 0; i < bodies.size(); ++i) moving[i] = Moving(bodies[i]);
}

/// A free place, or that of no pair: kMaxPairs.
[[nodiscard]] std::size_t freePlace(BodyPairs& pairs) noexcept {
  std::size_t place = 0;
  while (place < pairs.places.count && pairs.places[place].used != 0) ++place;
  if (place == pairs.places.count && place < kMaxPairs) ++pairs.places.count;
  return place;
}

}  // namespace

FoundContacts findBodyContacts(std::span<const Collider> bodies, BodyPairs& pairs, double period_s,
                               Allowance& allowance) noexcept {
  FoundContacts found;
  AllMoving moving;
  describe(bodies, moving);
  PlaceTable places(pairs);
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    if (bodies[a].state == nullptr) continue;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (b == a || (b < a && bodies[b].state != nullptr)) continue;  // of two that move the first one comes first
      if (!isActive(bodies[a], bodies[b])) continue;
      const double apart = moving[a].radius_m + moving[b].radius_m + reachOf(moving[a], moving[b], period_s);
      const bool near =
          !bodies[a].absent && !bodies[b].absent && squaredLength(moving[a].centre - moving[b].centre) < apart * apart;
      std::uint8_t& slot = places.slot(a, b);
      if (!near) {
        if (slot != 0) pairs.places[slot - 1U].used = 0;
        if (slot != 0 && pairs.search.pair == slot) pairs.search.pair = 0;
        continue;
      }
      if (slot != 0) continue;
      const std::size_t place = freePlace(pairs);
      if (place == kMaxPairs) {
        found.areAllPairs = false;
        continue;
      }
      BodyPair& pair = pairs.places[place];
      pair.first = static_cast<std::uint16_t>(a);
      pair.second = static_cast<std::uint16_t>(b);
      pair.contacts.count = 0;
      pair.used = 1;
      pair.range_m = -1;
      pair.depth_m = 0;
      pair.relative = {};
      pair.rolling_Nms = Vec3(0);
      pair.units = 0;
      slot = static_cast<std::uint8_t>(place + 1);
    }
  }
  while (pairs.places.count > 0 && pairs.places[pairs.places.count - 1].used == 0) --pairs.places.count;

  for (std::size_t i = 0; i < pairs.places.count; ++i) {
    BodyPair& pair = pairs.places[i];
    if (pair.used == 0 || (!bodies[pair.first].isPut && !bodies[pair.second].isPut)) continue;
    pair.range_m = -1;
    pair.depth_m = std::min(moving[pair.first].radius_m, moving[pair.second].radius_m);
    if (pairs.search.pair == i + 1) pairs.search.pair = 0;
  }

  bool isFirst = true;
  for (std::size_t k = 0; k < pairs.places.count; ++k) {
    const std::size_t i = (pairs.next + k) % pairs.places.count;
    BodyPair& pair = pairs.places[i];
    if (pair.used == 0 || !isActive(bodies[pair.first], bodies[pair.second])) continue;
    const PairNow now(bodies, moving, pair, period_s);
    if (now.isKnown(pair)) continue;
    if (now.arePolytopes() && !allowance.isSpent()) {
      now.meet(pair, allowance);
      continue;
    }
    now.begin(i, pair, pairs.search);
    const bool isDone = look(now.first, now.second, now.step_m, pairs.search, isFirst, pair, allowance);
    isFirst = false;
    if (isDone && now.isKnown(pair)) continue;
    pairs.next = i;
    found.areAll = false;
    return found;
  }
  pairs.next = 0;
  return found;
}

void searchAhead(std::span<const Collider> bodies, BodyPairs& pairs, double period_s, Allowance& allowance) noexcept {
  const std::int64_t all = allowance.left();
  const auto isLong = [&](const BodyPair& pair) {
    return pair.used != 0 && static_cast<std::int64_t>(pair.units) > all &&
           isActive(bodies[pair.first], bodies[pair.second]);
  };
  if (std::ranges::none_of(pairs.all(), isLong)) return;
  AllMoving moving;
  describe(bodies, moving);
  for (std::size_t i = 0; i < pairs.places.count && !allowance.isSpent(); ++i) {
    BodyPair& pair = pairs.places[i];
    if (!isLong(pair)) continue;
    const PairNow now(bodies, moving, pair, period_s);
    if (now.movedSince(pair.relative) + (kTicksAhead - 1) * now.reach_m <= pair.range_m) continue;
    if (pairs.search.pair != 0 && pairs.search.pair != i + 1) continue;
    now.begin(i, pair, pairs.search);
    static_cast<void>(look(now.first, now.second, now.step_m, pairs.search, false, pair, allowance));
  }
}

}  // namespace haptics
