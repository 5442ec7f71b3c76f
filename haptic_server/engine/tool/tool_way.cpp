#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "haptic_server/engine/contact/near_bodies.h"
#include "haptic_server/engine/contact/tolerances.h"
#include "haptic_server/engine/geometry/enclosure.h"
#include "haptic_server/engine/tool/tool_contact.h"

// Which points a way may take into something, and the test of those.

namespace haptics {
namespace {

/// Of what tests cost, as margin; and of the estimate, from one way to the next where they cost less.
constexpr double kTestMargin = 1.5, kTestDecay = 0.95;

/// Of a place from a triangle's plane.
[[nodiscard]] double heightOver(const CollisionMesh& surface, std::uint32_t triangle, Vec3 at) noexcept {
  return std::abs(glm::dot(surface.faceNormal(triangle), at - surface.triangle(triangle).corner(0)));
}

/// Of a place from a surface, as far as `farthest`; a lower bound, 0 once the allowance is spent.
[[nodiscard]] double distanceFrom(const CollisionMesh& surface, Vec3 at, double farthest,
                                  Allowance& allowance) noexcept {
  constexpr double kNearEnough = 0.64;  // of the squared distance: what is hardly nearer is not looked for
  double nearest = farthest * farthest / kNearEnough;
  allowance.spend(Allowance::kQuery);
  surface.hierarchy().visitNear(
      at, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t)
          nearest = std::min(nearest, closestOn(surface.triangle(t), t, at).squaredDistance);
        return kNearEnough * nearest;
      },
      kNearEnough * nearest);
  return allowance.isSpent() ? 0 : std::sqrt(kNearEnough * nearest);
}

}  // namespace

/// A body that an edit puts onto the tool would hold some of its points inside and others outside, for ever where it surrounds the
/// tool. So the tool passes it freely until it is clear of it.
void ToolContact::seeWhatIsAround(std::span<const Body> bodies, Allowance& allowance) noexcept {
  const std::int64_t keep = allowance.left() / 2;
  bool isOther = false;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    ToolObstacleState& state = memory_.bodies[b];
    if (!(state.isNew || state.isAround) || bodies[b].pendingRemoval) continue;
    const auto known = isIn(bodies[b], state, keep, allowance);
    if (!known) continue;
    isOther |= *known != state.isAround;
    state.isNew = false;
    state.isAround = *known;
  }
  if (!isOther) return;
  memory_.isOnWay = false;
  memory_.cursor = 0;
  forgetClearances();
}

/// Is a point of the tool in the body? Looks at one after another, in several ticks where they are many, and again at the one that was.
/// What is less than a millimetre in a new body is not: so far an edit may move a surface on which the tool rests.
std::optional<bool> ToolContact::isIn(const Body& body, ToolObstacleState& state, std::int64_t keep,
                                      Allowance& allowance) const noexcept {
  constexpr double kSunk_m = 1e-3, kFlush_m = 1e-5;
  const double reach = body.surface->radius_m() + scratch_.tool->shell.radius_m;
  const std::size_t count = memory_.clearTo.count;
  allowance.spend(Allowance::kSphere);
  if (!body.surface->closed() || squaredLength(body.centre - memory_.proxy.position) > reach * reach) return false;
  const Frames tool = framesAt(memory_.proxy);
  const double least_m = state.isAround ? kFlush_m : kSunk_m;
  for (; state.clear < count; ++state.clear) {
    if (allowance.left() <= keep) return std::nullopt;
    allowance.spend(Allowance::kPlace);
    const Vec3 at = body.frame.toLocal(tool.jaw[jawOf(state.next)].toWorld(point(state.next)));
    const bool isInside = windingNumber(*body.surface, at, allowance) > 0 &&
                          distanceFrom(*body.surface, at, 2 * least_m, allowance) > least_m;
    if (allowance.isSpent()) return std::nullopt;
    if (isInside) {
      state.clear = 0;
      return true;
    }
    state.next = state.next + 1 < count ? state.next + 1 : 0;
  }
  return false;
}

/// Does no point enter a surface on its way to that pose, as seen from each body and from the tool? Else scratch_.hits are the first
/// ones found; or there are none, and the allowance was spent before the point scratch_.tested.
/// @param from  The points before it have been tested on this way.
bool ToolContact::isClear(std::span<const Body> bodies, const ToolPose& next, double bound, Allowance& allowance,
                          std::size_t from) noexcept {
  const std::int64_t before = allowance.left();
  scratch_.tested = from;
  scratch_.hitCount = 0;
  scratch_.firstHit = 1;
  scratch_.lowestHit = std::numeric_limits<double>::infinity();
  const Frames frames = framesAt(next);
  std::int64_t tests = testPoints(bodies, frames, bound, allowance);
  if (!allowance.isSpent()) tests += testBodysPoints(bodies, frames, bound, allowance);
  learnTestCost(tests, before - allowance.left());
  return scratch_.hitCount == 0 && !allowance.isSpent();
}

/// Where a point enters a body's surface. What the contact of a point takes for a gap (isInGap()) lets no point of a tool
/// through.
Crossing ToolContact::crossingBesideGaps(std::span<const Body> bodies, std::size_t index, Vec3 from, Vec3 to,
                                         Allowance& allowance) const noexcept {
  const CollisionMesh& surface = *bodies[index].surface;
  const Crossing rimmed = surface.firstCrossing<RimmedSegment>(
      from, to, !surface.closed(), allowance, [](std::uint32_t) noexcept { return false; }, kRim * surface.extent_m());
  if (!rimmed.isBeside) return rimmed;
  const Crossing entered = surface.firstCrossing(from, to, allowance);
  const Vec3 here = toWorld(memory_.bodies[index].at, from), there = bodies[index].frame.toWorld(to);
  constexpr std::size_t kMaxBodies = 16;
  std::array<NearBody, kMaxBodies> near;  // not all of it is written
  std::size_t count = 0;
  const auto admit = [&](std::size_t b) noexcept {
    near[count++] = {static_cast<int>(b), false, bodies[b].surface, toLocal(memory_.bodies[b].at, here),
                     bodies[b].frame};
  };
  admit(index);
  for (std::size_t b = 0; b < bodies.size() && count < kMaxBodies; ++b) {
    const Body& body = bodies[b];
    const double radius = body.surface->radius_m() + glm::distance(here, there) + scratch_.bodyMoved[b];
    if (b != index && isFelt(bodies, b) && squaredLength(there - body.centre) <= radius * radius) admit(b);
  }
  return isInGap(std::span(near).first(count), near[0], to, rimmed, entered, allowance) ? rimmed : entered;
}

/// The tool's points from scratch_.tested on, against the surfaces of bodies; how many needed it.
std::int64_t ToolContact::testPoints(std::span<const Body> bodies, const Frames& tool, double bound,
                                     Allowance& allowance) noexcept {
  const double travelled = memory_.travelled + memory_.moved + bound;
  const Frames now = framesAt(memory_.proxy);
  std::int64_t tests = 0;
  for (; scratch_.tested < memory_.clearTo.count; ++scratch_.tested) {
    if (travelled < memory_.clearTo[scratch_.tested]) continue;
    ++tests;
    allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies.size()));
    const std::size_t jaw = jawOf(scratch_.tested);
    const Vec3 here = now.jaw[jaw].toWorld(point(scratch_.tested)),
               there = tool.jaw[jaw].toWorld(point(scratch_.tested));
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Body& body = bodies[b];
      const double radius = body.surface->radius_m() + bound + scratch_.bodyMoved[b];
      if (!isFelt(bodies, b) || squaredLength(there - body.centre) > radius * radius) continue;
      const Vec3 from = toLocal(memory_.bodies[b].at, here);
      const Vec3 to = body.frame.toLocal(there);
      const bool mayHaveGaps = bodies.size() > 1 || !body.surface->closed() || body.surface->anySelfIntersecting();
      const Crossing crossing = mayHaveGaps ? crossingBesideGaps(bodies, b, from, to, allowance)
                                            : body.surface->firstCrossing(from, to, allowance);
      if (allowance.isSpent()) return tests;
      if (!crossing) continue;
      const auto point = static_cast<std::uint16_t>(scratch_.tested), of = static_cast<std::uint16_t>(b);
      addHit({0, point, of, crossing.triangle, crossing.side, memory_.search, {}, {}, 0}, crossing.time,
             heightOver(*body.surface, crossing.triangle, from));
    }
  }
  return tests;
}

/// The sharp points of bodies from scratch_.tested on, against the tool's own surface; how many needed it.
std::int64_t ToolContact::testBodysPoints(std::span<const Body> bodies, const Frames& tool, double bound,
                                          Allowance& allowance) noexcept {
  const bool hasJaws = scratch_.tool->jaws.has_value();
  const Pose upper = jawPose(memory_.proxy, 0);
  std::int64_t tests = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    const auto [points, first] = scratch_.sharp[b];
    const double travelled = memory_.bodies[b].travelled + scratch_.bodyMoved[b] + bound;
    const double reach = scratch_.tool->shell.radius_m + bound + scratch_.bodyMoved[b];
    if (points.empty() || !isFelt(bodies, b)) continue;
    if (glm::distance(body.centre, tool.origin) > body.surface->radius_m() + reach) continue;
    const std::size_t begin = memory_.clearTo.count + first;
    double* const clearTo = memory_.sharpClearTo.items.data() + first;
    for (std::size_t j = std::max(scratch_.tested, begin) - begin; j < points.size(); ++j) {
      if (travelled < clearTo[j]) continue;
      const Vec3 place = body.frame.toWorld(points[j]);
      const double beyond = glm::distance(place, tool.origin) - reach;
      if (beyond > 0) {
        clearTo[j] = memory_.bodies[b].travelled + beyond;
        continue;
      }
      ++tests;
      scratch_.tested = begin + j;
      const Vec3 from = toLocal(upper, toWorld(memory_.bodies[b].at, points[j]));
      const Crossing crossing = scratch_.tool->surface->firstCrossing(from, tool.jaw[0].toLocal(place), allowance);
      if (hasJaws) testOnLowerJaw(bodies, b, j, tool, allowance);
      if (allowance.isSpent()) return tests;
      if (!crossing || isFlushWithHeld(bodies, b, place, allowance)) continue;
      const auto point = static_cast<std::uint16_t>(j), of = static_cast<std::uint16_t>(b);
      addHit({1, point, of, crossing.triangle, crossing.side, memory_.search, place, {}, 0}, crossing.time,
             heightOver(*scratch_.tool->surface, crossing.triangle, from));
    }
  }
  return tests;
}

/// A sharp point of a body, as testBodysPoints() tests it on the upper one.
void ToolContact::testOnLowerJaw(std::span<const Body> bodies, std::size_t b, std::size_t j, const Frames& tool,
                                 Allowance& allowance) noexcept {
  const CollisionMesh& surface = jawSurface(1);
  const Vec3 sharp = scratch_.sharp[b].points[j], place = bodies[b].frame.toWorld(sharp);
  const Vec3 from = toLocal(jawPose(memory_.proxy, 1), toWorld(memory_.bodies[b].at, sharp));
  const Crossing crossing = surface.firstCrossing(from, tool.jaw[1].toLocal(place), allowance);
  if (allowance.isSpent() || !crossing || isFlushWithHeld(bodies, b, place, allowance)) return;
  const auto point = static_cast<std::uint16_t>(j), of = static_cast<std::uint16_t>(b);
  addHit({2, point, of, crossing.triangle, crossing.side, memory_.search, place, {}, 0}, crossing.time,
         heightOver(surface, crossing.triangle, from));
}

/// Does a sharp point of a body lie flush in the surface of another one that a point of the tool stays above? Rounding has it a
/// little above that: to a steep side of the tool it would be a wall.
bool ToolContact::isFlushWithHeld(std::span<const Body> bodies, std::size_t index, const Vec3& place,
                                  Allowance& allowance) const noexcept {
  const auto isFlushWith = [&](const Touch& touch) noexcept {
    if (touch.ofBody || touch.body == index) return false;
    const Body& held = bodies[touch.body];
    const double gap_m = 2 * kRim * std::max(held.surface->extent_m(), bodies[index].surface->extent_m());
    const double reach = held.surface->radius_m() + gap_m;
    allowance.spend(Allowance::kSphere);
    if (allowance.isSpent() || squaredLength(place - held.centre) > reach * reach) return false;
    allowance.spend(Allowance::kPlace);
    const Vec3 at = held.frame.toLocal(place);
    if (heightOver(*held.surface, touch.triangle, at) > gap_m) return false;
    const double distance_m = distanceFrom(*held.surface, at, 2 * gap_m, allowance);
    return !allowance.isSpent() && distance_m <= gap_m;
  };
  const std::span touching(memory_.touches.items.data(), memory_.touches.count);
  return std::ranges::any_of(std::span(scratch_.hits).first(scratch_.hitCount), isFlushWith) ||
         std::ranges::any_of(touching, isFlushWith);
}

void ToolContact::addHit(const Touch& hit, double time, double height) noexcept {
  scratch_.firstHit = std::min(scratch_.firstHit, time);
  scratch_.lowestHit = std::min(scratch_.lowestHit, height);
  if (scratch_.hitCount < ToolScratch::kMaxHits) scratch_.hits[scratch_.hitCount++] = hit;
}

/// False: no new one is among them, and the planes that are known do not keep the points where they are to be.
bool ToolContact::addHits() noexcept {
  bool added = false;
  for (const Touch& hit : std::span(scratch_.hits).first(scratch_.hitCount)) {
    std::size_t end = memory_.touches.count;  // behind the last one of the same point
    while (end > 0 && !memory_.touches[end - 1].isOf(hit)) --end;
    const bool known = std::any_of(touches().begin(), touches().begin() + static_cast<std::ptrdiff_t>(end),
                                   [&](const Touch& t) { return t.isOf(hit) && t.triangle == hit.triangle; });
    if (known || memory_.touches.count == kMaxHalfSpaces) continue;
    const std::size_t place = end == 0 ? memory_.touches.count : end;  // those of a point one after another
    const auto last = memory_.touches.items.begin() + static_cast<std::ptrdiff_t>(memory_.touches.count);
    std::copy_backward(memory_.touches.items.begin() + static_cast<std::ptrdiff_t>(place), last, last + 1);
    memory_.touches[place] = hit;
    ++memory_.touches.count;
    added = true;
  }
  return added;
}

/// How many points would have to be tested on a way of this length.
std::int64_t ToolContact::testsWithin(double bound) const noexcept {
  const auto countDue = [](const double* clearTo, std::size_t count, double travelled) {
    return std::count_if(clearTo, clearTo + count, [=](double until) { return until <= travelled; });
  };
  auto due = countDue(memory_.clearTo.items.data(), memory_.clearTo.count, memory_.travelled + memory_.moved + bound);
  for (std::size_t b = 0; b < memory_.bodies.count; ++b) {
    due += countDue(memory_.sharpClearTo.items.data() + scratch_.sharp[b].first, scratch_.sharp[b].points.size(),
                    memory_.bodies[b].travelled + scratch_.bodyMoved[b] + bound);
  }
  return due;
}

/// Does the allowance last for the tests of a way of this length?
bool ToolContact::canTest(double bound, const Allowance& allowance) const noexcept {
  return static_cast<double>(allowance.left()) >= memory_.testCost * static_cast<double>(testsWithin(bound));
}

void ToolContact::learnTestCost(std::int64_t tests, std::int64_t spent) noexcept {
  if (tests == 0) return;
  const double measured = static_cast<double>(spent) / static_cast<double>(tests);
  memory_.testCost = std::max({kCheapestTest, kTestDecay * memory_.testCost, kTestMargin * measured});
}

/// Asks the next `count` points, in turn, how far everything was from them when the proxy moved last, those that may have met
/// something by then; as long as the allowance has more than `keep` left.
void ToolContact::renewClearances(std::span<const Body> bodies, std::size_t count, std::int64_t keep,
                                  Allowance& allowance) noexcept {
  const std::size_t all = pointCount();
  const Frames tool = framesAt(memory_.proxy);
  for (std::size_t i = 0; i < count && allowance.left() > keep; ++i) {
    std::size_t at = memory_.cursor;
    memory_.cursor = memory_.cursor + 1 == all ? 0 : memory_.cursor + 1;
    if (at < memory_.clearTo.count) {
      if (memory_.travelled >= memory_.clearTo[at])
        memory_.clearTo[at] = memory_.travelled + clearance(bodies, tool.jaw[jawOf(at)].toWorld(point(at)), allowance);
      continue;
    }
    at -= memory_.clearTo.count;
    double& clearTo = memory_.sharpClearTo[at];
    const auto end = scratch_.sharp.begin() + static_cast<std::ptrdiff_t>(memory_.bodies.count);
    const auto next = std::upper_bound(scratch_.sharp.begin(), end, at,
                                       [](std::size_t p, const ToolScratch::Sharp& s) { return p < s.first; });
    const auto b = static_cast<std::size_t>(next - scratch_.sharp.begin()) - 1;
    if (memory_.bodies[b].travelled < clearTo) continue;
    const Vec3 place = toWorld(memory_.bodies[b].at, scratch_.sharp[b].points[at - scratch_.sharp[b].first]);
    const double arm = glm::distance(place, tool.origin), radius = scratch_.tool->shell.radius_m;
    double distance = kFarthestClearance_m;
    for (std::size_t jaw = 0; jaw < jawCount(); ++jaw)
      distance = distanceFrom(jawSurface(jaw), tool.jaw[jaw].toLocal(place), distance, allowance);
    // Beyond the tool's sphere a turn takes it farther than the tool's own points.
    clearTo = memory_.bodies[b].travelled + std::max(arm - radius, distance * std::min(1.0, radius / (arm + distance)));
  }
}

/// How far the place may move before it can meet anything; a lower bound.
double ToolContact::clearance(std::span<const Body> bodies, Vec3 place, Allowance& allowance) const noexcept {
  double clear = kFarthestClearance_m;
  allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies.size()));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const CollisionMesh& surface = *bodies[b].surface;
    const double reach = surface.radius_m() + clear + scratch_.bodyMoved[b];
    if (!isFelt(bodies, b) || squaredLength(place - bodies[b].centre) > reach * reach) continue;
    allowance.spend(Allowance::kPlace);
    const Vec3 at = toLocal(memory_.bodies[b].at, place);
    if (glm::distance(at, surface.centre()) - surface.radius_m() < clear)
      clear = distanceFrom(surface, at, clear, allowance);
  }
  return clear;
}

}  // namespace haptics
