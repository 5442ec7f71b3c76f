// Several surfaces hold the IHIP: up to three, as the god-object is held (Zilles and Salisbury 1995).

#include <limits>

#include "haptic_server/engine/contact/active_set.h"
#include "haptic_server/engine/contact/plane_solver.h"

namespace haptics {
namespace {

using Mode = ContactState::Mode;

/// A solver step, and whether the IHIP stays where it led.
struct Round {
  SolverStep step;
  bool settled = false;
  bool watchBlocked = false;  ///< Something else is in the way of the neighborhood watch from there.
};

/// Leaves the IHIP where it was blocked (severalSurfaces off).
void stayInPlace(TickContext& tick) noexcept {
  ClosestPoint foot;
  foot.triangle = tick.held().triangle;
  foot.point = tick.state.local;
  tick.setOneSurface(tick.held(), foot, tick.nearOf(tick.held()).frame.toWorld(foot.point));
}

/// The triangle's normal, and those of the neighbours across the lines that a place of it is on.
Vec3 normalsAt(const CollisionMesh& surface, std::uint32_t triangle, Vec3 place, double onLine_m) noexcept {
  const TriangleRecord& record = surface.triangle(triangle);
  Vec3 sum = surface.faceNormal(triangle);
  for (int k = 0; k < 3; ++k) {
    const Vec3 from = record.corner(k), along = record.corner(nextCorner(k)) - from;
    const bool isOn = squaredLength(glm::cross(place - from, along)) <= onLine_m * onLine_m * squaredLength(along);
    if (isOn && record.neighbour(k) != kNoTriangle) sum += surface.faceNormal(record.neighbour(k));
  }
  return sum;
}

/// Is a body other than this one in the way to a place in the world?
bool isBlockedByOther(TickContext& tick, const NearBodies::Near& own, Vec3 world) noexcept {
  const auto isOwn = [&](int i, std::uint32_t) noexcept { return &tick.near[i] == &own; };
  return static_cast<bool>(tick.near.firstHit(tick.near.inEachFrame(world), isOwn, tick.work));
}

/// The pushing triangles are really under the IHIP, not only their planes: the planes' optimum is a local optimum.
bool isSupportedBy(const TickContext& tick, const SolverStep& step) noexcept {
  return step.supportKnown || std::ranges::all_of(step.pushing(), [&](const ContactSurface& s) {
           return isWithin(tick, kSupportMargin, s);
         });
}

/// One straight move: to the optimum of the planes of all that is in touch and in the way, as far as it is supported,
/// or to what is met on the way, and no farther than `longest_m`.
SolverStep moveTowards(TickContext& tick, Vec3 hip, double longest_m) noexcept {
  const double touchMargin_m = kTouchMargin * tick.skin;
  const Vec3& ihip = tick.state.ihip;
  Constraints constraints(hip, tick.skin);
  const bool pendingMotion = hasPendingBodyMotion(tick);
  while (true) {
    tick.work.allowance.spend(Allowance::kPlanes);
    SolverStep step = constraints.stepToOptimum();
    const SupportLimit limit = supportLimit(tick, step.pushing(), constraints);
    std::optional<ContactSurface> next;
    if (limit.ends) {
      const double length = glm::distance(ihip, step.to);
      next = across(tick, step.surfaces[limit.surface], limit.edge);
      if (limit.time * length <= touchMargin_m && next && constraints.isCutOffBy(planeOf(tick, *next))) {
        Constraints both = constraints;
        if (both.add(planeOf(tick, *next))) {
          constraints = both;
          continue;
        }
      }
      step.reachedOptimum = false;
      if (!pendingMotion) {
        step.to = glm::mix(ihip, step.to, std::min(std::max(limit.time, tick.skin / length), 1.0));
      }
    }
    if (const double length = glm::distance(ihip, step.to); length > longest_m && !pendingMotion) {
      step.reachedOptimum = false;
      step.to = glm::mix(ihip, step.to, longest_m / length);
      next.reset();
    }
    const NearBodies::Hit hit = tryMoveTo(tick, step.to);
    if (!hit) {
      if (next) step.switchToNeighbour(limit.surface, *next);
      return step;
    }
    const ConstraintPlane plane = planeOf(tick, {tick.near[hit.near].body, hit.crossing.side, hit.crossing.triangle});
    const double clear = plane.reachedAt(ihip, step.to);
    if (!pendingMotion && clear * glm::distance(ihip, step.to) > touchMargin_m) {
      SolverStep met{.done = true,
                     .to = glm::mix(ihip, step.to, clear),
                     .pushingCount = 1,
                     .touchedCount = step.pushingCount,
                     .surfaces = {plane.surface}};
      std::ranges::copy(step.pushing(), met.surfaces.begin() + 1);
      if (!tryMoveTo(tick, met.to)) return met;
    }
    if (!constraints.add(plane)) return {};
  }
}

Round moveInRound(TickContext& tick, Vec3 hip, double longest_m, int& stalledRounds) noexcept {
  const Vec3& ihip = tick.state.ihip;
  const Vec3 from = ihip;
  Round round{moveTowards(tick, hip, longest_m)};
  SolverStep& step = round.step;
  if (!step.done) return round;
  const double moved_m = glm::distance(ihip, from);
  const bool converged = step.reachedOptimum && (step.pushingCount == 0 || isSupportedBy(tick, step) ||
                                                 moved_m <= kConvergedRatio * glm::distance(step.to, hip));
  const Vec3 optimum = ihip;
  const Watch watch = continueWatch(tick, hip, step);
  round.watchBlocked = watch == Watch::kBlocked;
  const bool stays = glm::distance(ihip, optimum) <= (round.watchBlocked ? kGap * tick.skin : 0);
  const bool nearer = glm::distance(ihip, hip) < glm::distance(from, hip);
  stalledRounds += nearer ? 0 : 1;
  round.settled = watch == Watch::kEnded || (converged && stays) || stalledRounds > kMaxStalledRounds;
  return round;
}

/// Remembers what pushes. One surface left, and the IHIP really over it: back to the neighborhood watch, which is
/// cheaper and exact there. The planes of several triangles around one vertex are one surface too: held above all of
/// them the IHIP would stay at a saddle's vertex, where it could come nearer to the HIP above some. The watch goes on
/// from the place on the triangle that is the closest to the HIP: not where that is another place than the IHIP's, nor
/// where the skin that the solver keeps is filled by another surface.
void updateMode(TickContext& tick, Vec3 hip, const Round& last) noexcept {
  const SolverStep& step = last.step;
  if (!step.done) {
    tick.state.holdingCount = 0;  // holding[0] stays: the contact belongs to it
    return;
  }
  if (step.pushingCount == 0 && last.settled) return tick.setFree(hip);
  tick.setSeveralSurfaces(step.pushing());
  const ContactSurface held = tick.held();
  if (!last.settled || last.watchBlocked || !isOneSurface(tick, step) || !isWithin(tick, kRecontactMargin, held) ||
      tick.isSelfIntersecting(held))
    return;
  const NearBodies::Near& near = tick.nearOf(held);
  const ClosestPoint foot = closestOn(near.surface->triangle(held.triangle), held.triangle, near.frame.toLocal(hip));
  if (squaredLength(foot.point - near.from) > kTouchMargin * kTouchMargin * tick.skin * tick.skin) return;
  if (tick.near.count() > 1 && tryMoveTo(tick, near.frame.toWorld(tick.lifted(foot.point, held, tick.pathOffset))))
    return;
  tick.setOneSurface(held, foot, near.frame.toWorld(foot.point));
}

}  // namespace

/// The solver starts, in the contacted body's frame, off the triangle by a lift, and a little of the way to the
/// triangle's middle, which puts it above the neighbours across a valley too; where another body is in that way, it is lifted
/// off them as well. Other bodies' frames keep their starts.
/// From there straight up by a skin, where nothing is above: on the way along a surface it would run into the side of one
/// that is flush with it but for rounding.
void takeOver(TickContext& tick, Vec3 hip) noexcept {
  if (!tick.corrections.severalSurfaces) return stayInPlace(tick);
  // From the largest pull that meets no other body, in steps of 8.
  constexpr double kPull = 0x1p-10;
  constexpr double kMinPull = 0x1p-20;
  NearBodies::Near& own = tick.near[tick.near.indexOf(tick.held().body)];
  const CollisionMesh& s = *own.surface;
  const std::uint32_t t = tick.held().triangle;
  const TriangleRecord& record = s.triangle(t);
  const Vec3 middle = (record.corner(0) + record.corner(1) + record.corner(2)) * (1 / 3.0);
  Vec3 inner = tick.state.local;
  for (double pull = kPull; pull > kMinPull && !tick.work.allowance.isSpent(); pull /= 8) {
    const Vec3 pulled = glm::mix(tick.state.local, middle, pull);
    if (isBlockedByOther(tick, own, own.frame.toWorld(pulled))) continue;
    inner = pulled;
    break;
  }
  own.from = inner + normalsAt(s, t, inner, tick.startOffset) * (tick.held().side * tick.startOffset);
  tick.state.ihip = own.frame.toWorld(own.from);
  static_cast<void>(tryMoveTo(tick, own.frame.toWorld(inner + s.faceNormal(t) * (tick.held().side * tick.skin))));
  solvePlanes(tick, hip);
}

/// The IHIP moves towards the point nearest to the HIP above all planes met so far; what it is in touch with and blocks
/// it adds a plane. A move goes no farther than its support, or to what it comes to on the way, so that the IHIP
/// keeps to the surfaces as a slow hand's would. Then the planes are forgotten and met anew from there, which is what
/// releases them. Wherever surfaces hold that are known, they are followed without meeting them.
/// A pocket that moving bodies close entirely has no place for the IHIP: it is then let through one of them.
void solvePlanes(TickContext& tick, Vec3 hip) noexcept {
  constexpr int kFewRounds = 4;  // of a tick that covers a part of its path only
  const bool wholePath = tick.stride == 1;
  const int maxRounds = wholePath ? kMaxSolverRounds : kFewRounds;
  const double longest_m =
      wholePath ? std::numeric_limits<double>::infinity() : tick.stride * glm::distance(tick.state.ihip, hip);
  Round last;
  if (wholePath && tick.state.mode == Mode::kSeveralSurfaces && tick.state.holdingCount > 0) {
    last.step = followActiveSet(tick, hip);
    last.settled = last.step.done && isSupportedBy(tick, last.step) &&
                   !(isOneSurface(tick, last.step) && last.step.pushingCount > 1);
  }
  tick.state.mode = Mode::kSeveralSurfaces;
  int stalledRounds = 0;
  for (int i = 0; i < maxRounds && !last.settled && !tick.work.allowance.isSpent(); ++i) {
    ++tick.work.solverRounds;
    const Round moved = moveInRound(tick, hip, longest_m, stalledRounds);
    if (!moved.step.done) break;
    last = moved;
    if (last.settled || !wholePath || last.step.pushingCount < 2 || isOneSurface(tick, last.step)) continue;
    tick.setSeveralSurfaces(last.step.pushing());
    const SolverStep followed = followActiveSet(tick, hip);
    if (followed.done) last = {followed, isSupportedBy(tick, followed) && !isOneSurface(tick, followed)};
  }
  tick.work.notConverged = tick.work.notConverged || !last.settled;
  updateMode(tick, hip, last);
}

}  // namespace haptics
