#include "haptic_server/engine/collision/body_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "haptic_server/engine/collision/near_points.h"
#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {
namespace {

/// Points are looked for anew once a body has moved so far against the other, of the smaller one's radius. Smaller looks
/// more often; larger lets round bodies roll on points that are no longer the lowest.
constexpr double kStaleAfter = 0.01;
/// Likewise of two polytopes of few faces, which costs less.
constexpr double kPolytopesStaleAfter = 0.001;
/// As rounding makes of poses that are one.
constexpr double kUnmoved_m = 1e-9;
/// A range lasts for so many ticks but one, unless bodies are faster than it is worth.
constexpr double kTicksOfRange = 4;
/// A search that takes more than a tick begins so many ticks before the range ends.
constexpr double kTicksAhead = 3;
/// Steps that bodies are lifted over rather than stopped by, of the smaller one's radius, and m. Flush bodies have such ones:
/// what rests on them is up to 20 um deep in each.
constexpr double kStep = 0.003, kLowestStep_m = 10e-6, kHighestStep_m = 50e-6;

/// A body and what the search needs of it.
struct Moving {
  Vec3 centre;  // of the sphere, world
  double radius_m;
  Vec3 velocity;     // of its pivot()
  double spin_m_s;   // of the farthest point about it
  double speed_m_s;  // of its fastest point, at most

  explicit Moving(const Collider& body) noexcept
      : centre(toWorld(body.pose, body.surface->centre())),
        radius_m(body.surface->radius_m()),
        velocity(0),
        spin_m_s(0),
        speed_m_s(0) {
    if (!isAwake(body) && !body.isDriven) return;
    const RigidVelocity v = body.isDriven ? body.before : velocityOf(*body.rigidBody, *body.state);
    velocity = v.linear;
    spin_m_s = glm::length(v.angular) * (radius_m + glm::distance(centre, body.pivot()));
    speed_m_s = glm::length(velocity) + spin_m_s;
  }
  Moving() = default;
};

/// How far two bodies get against each other in a tick, at most; m.
[[nodiscard]] double reachOf(const Moving& a, const Moving& b, double period_s) noexcept {
  return period_s * (glm::distance(a.velocity, b.velocity) + a.spin_m_s + b.spin_m_s);
}

/// Which two of the bodies are a pair: a bit for each two.
class PairSet {
 public:
  explicit PairSet(std::size_t bodies) noexcept : bodies_(bodies) {
    std::fill_n(words_.begin(), (bodies * bodies + kBits - 1) / kBits, std::uint64_t{0});
  }
  void add(std::size_t first, std::size_t second) noexcept {
    const std::size_t at = first * bodies_ + second;
    words_[at / kBits] |= std::uint64_t{1} << (at % kBits);
  }
  [[nodiscard]] bool has(std::size_t first, std::size_t second) const noexcept {
    const std::size_t at = first * bodies_ + second;
    return (words_[at / kBits] >> (at % kBits) & 1) != 0;
  }

 private:
  static constexpr std::size_t kBits = 64;
  std::size_t bodies_;
  std::array<std::uint64_t, kMaxColliders * kMaxColliders / kBits> words_;  // as far as they are used
};

[[nodiscard]] Pose relativePose(const Pose& first, const Pose& second) noexcept {
  const Quat back = glm::conjugate(second.rotation);
  return {glm::normalize(back * first.rotation), back * (first.position - second.position)};
}

/// How far any place within `extent_m` of the first body's origin has moved against the second.
[[nodiscard]] double movedBy(const Pose& was, const Pose& is, double extent_m) noexcept {
  const Quat turn = is.rotation * glm::conjugate(was.rotation);
  return glm::distance(was.position, is.position) + 2 * extent_m * glm::length(Vec3(turn.x, turn.y, turn.z));
}

/// How a pair is in this tick.
struct PairNow {
  PairNow(std::span<const Collider> bodies, std::span<const Moving> moving, const BodyPair& pair,
          double tickPeriod_s) noexcept
      : first(bodies[pair.first]),
        second(bodies[pair.second]),
        relative(relativePose(first.pose, second.pose)),
        period_s(tickPeriod_s),
        reach_m(reachOf(moving[pair.first], moving[pair.second], tickPeriod_s)),
        smaller_m(std::min(moving[pair.first].radius_m, moving[pair.second].radius_m)),
        step_m(std::clamp(kStep * smaller_m, kLowestStep_m, kHighestStep_m)) {}

  const Collider &first, &second;
  const Pose relative;
  const double period_s;
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
    // A pair keeps few contacts: of those within the range of a higher speed not the ones that it comes to rest on.
    constexpr double kWiderThanNeeded = 2;
    const bool isFresh = haveFewFaces() ? moved_m <= range_m() : pair.range_m <= kWiderThanNeeded * range_m();
    return (isFresh || pair.contacts.count == 0) && moved_m <= pair.range_m;
  }
  /// Within which points are contacts.
  [[nodiscard]] double range_m() const noexcept {
    if (haveFewFaces()) return reach_m + kPolytopesStaleAfter * smaller_m;
    const double stale = kStaleAfter * smaller_m;
    return std::max(reach_m, std::clamp(kTicksOfRange * reach_m, stale, kTicksOfRange * stale));
  }
  /// Two polytopes.
  [[nodiscard]] bool haveFewFaces() const noexcept {
    return arePolytopes() && first.points->polytope->hasFew() && second.points->polytope->hasFew();
  }
  [[nodiscard]] bool arePolytopes() const noexcept { return first.points->polytope && second.points->polytope; }
  /// Finds the contacts of two polytopes.
  void meet(BodyPair& pair, Allowance& allowance) const noexcept {
    const Quat back = glm::conjugate(second.pose.rotation);
    const auto velocityAt = [&](Vec3 place) {
      return back * (first.velocityBefore(place) - second.velocityBefore(place));
    };
    const PolytopeWay way{range_m(),
                          step_m,
                          velocityAt(second.pose.position),
                          back * (first.before.angular - second.before.angular),
                          pressedAlong(pair),
                          lastNormal(pair)};
    const PolytopeContact found = contactOf(*first.points->polytope, *second.points->polytope, relative, way);
    allowance.spend(found.units);
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
    if (found.isOneOfTwo) pair.range_m = reach_m + kUnmoved_m;  // to look again once they have moved
    pair.depth_m = std::max(0.0, -found.gap_m);
    pair.relative = relative;
    pair.units = 0;
  }
  /// The normal of the contacts that the last tick pressed, out of the second body in its frame; 0: none.
  [[nodiscard]] Vec3 pressedAlong(const BodyPair& pair) const noexcept {
    if (first.isPut || second.isPut) return Vec3(0);
    for (const BodyContact& contact : pair.contacts.all()) {
      if (contact.impulse_Ns != Vec3(0)) return normalOf(contact);
    }
    return Vec3(0);
  }
  [[nodiscard]] Vec3 lastNormal(const BodyPair& pair) const noexcept {
    return pair.contacts.count > 0 ? normalOf(pair.contacts[0]) : Vec3(0);
  }
  /// Out of the second body, in its frame.
  [[nodiscard]] Vec3 normalOf(const BodyContact& contact) const noexcept {
    return contact.second == 0 ? contact.normal : relative.rotation * -contact.normal;
  }
  /// Goes on with the search for the contacts of a pair. False: the allowance is spent, and the pair is as it was.
  [[nodiscard]] bool look(PairSearch& search, bool isFirst, BodyPair& pair, Allowance& allowance) const noexcept {
    NearPoints near(search, isFirst);
    const std::int64_t before = allowance.left();
    const auto isFound = [&] {
      if (search.clear_m > search.range_m) {
        const bool firstIsSmaller = first.surface->radius_m() <= second.surface->radius_m();
        const auto [smaller, other] = firstIsSmaller ? std::pair(&first, &second) : std::pair(&second, &first);
        near.lowerClearance(*smaller->surface, *other->surface,
                            firstIsSmaller ? search.relative : inverse(search.relative), allowance);
        if (search.clear_m > search.range_m) {
          near.choose({}, pair);
          return true;
        }
      }
      if (search.node == 0 && search.reverse == 0) {
        if (first.points->polytope &&
            near.findOn(first, second, search.relative, true, step_m, period_s, pair, allowance))
          return true;
        if (second.points->polytope &&
            near.findOn(second, first, inverse(search.relative), false, step_m, period_s, pair, allowance))
          return true;
      }
      if (search.reverse == 0) {
        if (!near.find(*first.points, *second.surface, search.relative, false, allowance)) return false;
        search.reverse = 1;
      }
      if (!near.find(*second.points, *first.surface, inverse(search.relative), true, allowance)) return false;
      near.choose(search.near.all(), pair);
      NearPoints::passSteps(first, second, search.relative, step_m, pair, allowance);
      return true;
    };
    const bool found = isFound();
    search.units += static_cast<std::uint64_t>(before - allowance.left());
    if (!found) return false;
    pair.range_m = pair.contacts.count == 0 ? search.clear_m : search.range_m;
    if (near.isOneOfTwo()) pair.range_m = reach_m + kUnmoved_m;  // to look again once they have moved
    pair.relative = search.relative;
    pair.units = search.units;
    search.pair = 0;
    return true;
  }
  /// Begins a search unless there is one of the pair that will be of use.
  void begin(std::size_t place, const BodyPair& pair, PairSearch& search) const noexcept {
    if (search.pair == place + 1 && movedSince(search.relative) <= search.range_m) return;
    const double range = range_m();
    const double clear = pair.contacts.count == 0 ? std::max(range, smaller_m) : range;
    search.begin(place, relative, range, range + pair.depth_m, clear);
  }
};

using AllMoving = std::array<Moving, kMaxColliders>;
void collectMoving(std::span<const Collider> bodies, AllMoving& moving) noexcept {
  for (std::size_t i = 0; i < bodies.size(); ++i) moving[i] = Moving(bodies[i]);
}

/// A free place; else that of a pair which does not meet in this tick; or of none: kMaxPairs.
[[nodiscard]] std::size_t roomIn(BodyPairs& pairs, std::span<const Collider> bodies, const AllMoving& moving,
                                 double period_s) noexcept {
  std::size_t place = 0;
  while (place < pairs.places.count && pairs.places[place].used != 0) ++place;
  if (place < pairs.places.count) return place;
  if (place < kMaxPairs) return pairs.places.count++;
  for (place = 0; place < kMaxPairs; ++place) {
    const BodyPair& pair = pairs.places[place];
    const bool isApart = pair.contacts.count == 0 && pairs.search.pair != place + 1;
    if (isApart && PairNow(bodies, moving, pair, period_s).isKnown(pair)) break;
  }
  return place;
}

}  // namespace

FoundContacts findBodyContacts(std::span<const Collider> bodies, BodyPairs& pairs, double period_s,
                               Allowance& allowance) noexcept {
  FoundContacts found;
  AllMoving moving;
  collectMoving(bodies, moving);
  const auto isNear = [&](std::size_t a, std::size_t b) noexcept {
    const double apart =
        moving[a].radius_m + moving[b].radius_m + period_s * (moving[a].speed_m_s + moving[b].speed_m_s);
    return squaredLength(moving[a].centre - moving[b].centre) < apart * apart && !bodies[a].absent && !bodies[b].absent;
  };
  PairSet known(bodies.size());
  for (std::size_t i = 0; i < pairs.places.count; ++i) {
    BodyPair& pair = pairs.places[i];
    if (pair.used == 0) continue;
    if (!isActive(bodies[pair.first], bodies[pair.second]) || isNear(pair.first, pair.second)) {
      known.add(pair.first, pair.second);
      continue;
    }
    pair.used = 0;
    if (pairs.search.pair == i + 1) pairs.search.pair = 0;
  }
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    if (bodies[a].state == nullptr) continue;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (b == a || (b < a && bodies[b].state != nullptr)) continue;  // of two that move the first one comes first
      if (!isNear(a, b) || !isActive(bodies[a], bodies[b]) || known.has(a, b)) continue;
      const std::size_t place = roomIn(pairs, bodies, moving, period_s);
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
    if (isFirst || !allowance.isSpent()) {
      if (now.arePolytopes()) {
        now.meet(pair, allowance);
        isFirst = false;
        continue;
      }
      now.begin(i, pair, pairs.search);
      const bool isDone = now.look(pairs.search, isFirst, pair, allowance);
      isFirst = false;
      if (isDone && now.isKnown(pair)) continue;
    }
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
  collectMoving(bodies, moving);
  for (std::size_t i = 0; i < pairs.places.count && !allowance.isSpent(); ++i) {
    BodyPair& pair = pairs.places[i];
    if (!isLong(pair)) continue;
    const PairNow now(bodies, moving, pair, period_s);
    if (now.movedSince(pair.relative) + (kTicksAhead - 1) * now.reach_m <= pair.range_m) continue;
    if (pairs.search.pair != 0 && pairs.search.pair != i + 1) continue;
    now.begin(i, pair, pairs.search);
    static_cast<void>(now.look(pairs.search, false, pair, allowance));
  }
}

}  // namespace haptics
