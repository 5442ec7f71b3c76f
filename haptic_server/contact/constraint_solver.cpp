// Several surfaces: the IHIP held by up to three, as the god-object is (Zilles and Salisbury 1995).

#include <algorithm>
#include <limits>
#include <utility>

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

/// From one surface to the solver. The start in the contacted body's frame: off its triangle by a lift, and a little of
/// the way to the triangle's middle, which puts it above the neighbours across a valley too. Other bodies' frames keep
/// theirs.
void ContactTick::resolve(Vec3 hip) noexcept {
  // From the largest pull that meets no other body, in steps of 8.
  constexpr double kPull = 0x1p-10;
  constexpr double kMinPull = 0x1p-20;
  Near& own = heldNear();
  const CollisionMesh& s = *own.surface;
  const std::uint32_t t = held().triangle;
  const TriangleRecord& record = s.triangle(t);
  const Vec3 middle = (record.corner(0) + record.corner(1) + record.corner(2)) * (1 / 3.0);
  Vec3 inner = state_.local;
  for (double pull = kPull; pull > kMinPull && !work_.allowance.isSpent(); pull /= 8) {
    inner = glm::mix(state_.local, middle, pull);
    if (!isBlockedByOther(own, own.frame.toWorld(inner))) break;
  }
  own.from = inner + s.faceNormal(t) * (held().side * startOffset_);
  state_.ihip = own.frame.toWorld(own.from);
  solve(hip);
}

/// One surface only (kSeveralSurfaces off).
void ContactTick::stayInPlace() noexcept {
  ClosestPoint foot;
  foot.triangle = held().triangle;
  foot.point = state_.local;
  hold(held(), foot, heldNear().frame.toWorld(foot.point));
}

/// The IHIP moves towards the point nearest to the HIP above all planes met so far; what it is in touch with and blocks
/// it adds a plane. A move goes no farther than what carries it, or to what it comes to on the way, so that the IHIP
/// keeps to the surfaces as a slow hand's would. Then the planes are forgotten and met anew from there, which is what
/// releases them. Wherever surfaces hold that are known, they are followed without meeting them.
/// A pocket that moving bodies close entirely has no place for the IHIP: it is then let through one of them.
void ContactTick::solve(Vec3 hip) noexcept {
  constexpr int kFewRounds = 4;  // of a tick that takes a part of its way only
  const bool whole = stride_ == 1;
  const int maxRounds = whole ? kMaxSolverRounds : kFewRounds;
  const double longest_m = whole ? std::numeric_limits<double>::infinity() : stride_ * glm::distance(state_.ihip, hip);
  SolverStep last;
  if (whole && state_.mode == Mode::kSeveralSurfaces && state_.holdingCount > 0) last = followActiveSet(hip);
  state_.mode = Mode::kSeveralSurfaces;
  bool settled = last.done && isSupportedBy(last) && !(isOneSurface(last) && last.count > 1);
  for (int round = 0, stalledRounds = 0; round < maxRounds && !settled && !work_.allowance.isSpent(); ++round) {
    ++work_.solverRounds;
    const Vec3 from = state_.ihip;
    SolverStep move = moveTowards(hip, longest_m);
    if (!move.done) break;
    const double way = glm::distance(state_.ihip, from);
    settled =
        move.whole && (move.count == 0 || isSupportedBy(move) || way <= kConvergedRatio * glm::distance(move.to, hip));
    const Vec3 start = state_.ihip;
    const bool ended = continueWatch(hip, move);
    settled = ended || (settled && state_.ihip == start);
    const bool nearer = glm::distance(state_.ihip, hip) < glm::distance(from, hip);
    stalledRounds += nearer ? 0 : 1;
    settled = settled || stalledRounds > kMaxStalledRounds;
    last = move;
    if (settled || !whole || move.count < 2 || isOneSurface(move)) continue;
    std::copy_n(move.pushing.begin(), move.count, state_.holding.begin());
    state_.holdingCount = move.count;
    const SolverStep followed = followActiveSet(hip);
    if (!followed.done) continue;
    last = followed;
    settled = isSupportedBy(last) && !isOneSurface(last);
  }
  work_.notConverged = work_.notConverged || !settled;
  updateMode(hip, last, settled);
}

/// One straight move: to the optimum of the planes of all that is in touch and in the way, as far as it is carried, or
/// to what is met on the way, and no farther than `longest_m`.
SolverStep ContactTick::moveTowards(Vec3 hip, double longest_m) noexcept {
  Constraints constraints(hip, skin_);
  const bool behind = hasPendingBodyMotion();
  while (true) {
    work_.allowance.spend(Allowance::kPlanes);
    SolverStep move = constraints.move();
    const auto pushing = move.allPushing();
    const SupportLimit limit = supportLimit(pushing, constraints);
    std::optional<ContactSurface> next;
    if (limit.ends) {
      const double way = glm::distance(state_.ihip, move.to);
      next = across(pushing[limit.surface], limit.edge);
      if (limit.time * way <= kTouchMargin * skin_ && next && constraints.isCutOffBy(planeOf(*next))) {
        Constraints both = constraints;
        if (both.add(planeOf(*next))) {
          constraints = both;
          continue;
        }
      }
      move.whole = false;
      if (!behind) move.to = glm::mix(state_.ihip, move.to, std::min(std::max(limit.time, skin_ / way), 1.0));
    }
    if (const double way = glm::distance(state_.ihip, move.to); way > longest_m && !behind) {
      move.whole = false;
      move.to = glm::mix(state_.ihip, move.to, longest_m / way);
      next.reset();
    }
    const Hit hit = tryMoveTo(move.to);
    if (!hit) {
      if (next) move.switchToNeighbour(limit.surface, *next);
      return move;
    }
    const ConstraintPlane plane = planeOf({near_[hit.near].body, hit.crossing.side, hit.crossing.triangle});
    const double clear = plane.reachedAt(state_.ihip, move.to);
    if (!behind && clear * glm::distance(state_.ihip, move.to) > kTouchMargin * skin_) {
      SolverStep met{true, false, false, glm::mix(state_.ihip, move.to, clear), 1, move.count, {plane.surface}};
      std::ranges::copy(pushing, met.pushing.begin() + 1);
      if (!tryMoveTo(met.to)) return met;
    }
    if (!constraints.add(plane)) return {};
  }
}

bool ContactTick::shareVertex(const ContactSurface& a, const ContactSurface& b) const noexcept {
  if (a.body != b.body) return false;
  const TriangleRecord& one = surface(a.body).triangle(a.triangle);
  const TriangleRecord& other = surface(a.body).triangle(b.triangle);
  return other.cornerOf(one.vertexAt(0)) >= 0 || other.cornerOf(one.vertexAt(1)) >= 0 ||
         other.cornerOf(one.vertexAt(2)) >= 0;
}

/// Is a body other than this one in the way to a place in the world?
bool ContactTick::isBlockedByOther(const Near& own, Vec3 world) noexcept {
  const auto isOwn = [&](int i, std::uint32_t) noexcept { return &near_[i] == &own; };
  return static_cast<bool>(near_.firstHit(near_.inEachFrame(world), isOwn, work_));
}

/// Straight to a place in the world, unless something is in the way.
ContactTick::Hit ContactTick::tryMoveTo(Vec3 world) noexcept {
  const Points to = near_.inEachFrame(world);
  const Hit hit = near_.firstHit(
      to, [](int, std::uint32_t) noexcept { return false; }, work_);
  if (hit) return hit;
  near_.moveAll(to, 1);
  state_.ihip = world;
  return hit;
}

/// The pushing triangles are really under the IHIP, not only their planes: the planes' optimum is a local optimum.
bool ContactTick::isSupportedBy(const SolverStep& move) const noexcept {
  return move.rests ||
         std::ranges::all_of(move.allPushing(), [&](const ContactSurface& s) { return isWithin(kSupportMargin, s); });
}

/// Is the IHIP no farther than so many skins from a triangle?
bool ContactTick::isWithin(double skins, const ContactSurface& s) const noexcept {
  const ClosestPoint foot =
      closestOn(surface(s.body).triangle(s.triangle), s.triangle, near_[near_.indexOf(s.body)].from);
  return foot.squaredDistance <= skins * skins * skin_ * skin_;
}

ConstraintPlane ContactTick::planeOf(const ContactSurface& holding) const noexcept {
  const Near& near = near_[near_.indexOf(holding.body)];
  const Vec3 normal = near.frame.rotate(near.surface->faceNormal(holding.triangle) * static_cast<double>(holding.side));
  const Vec3 corner = near.frame.toWorld(near.surface->triangle(holding.triangle).corner(0));
  return {normal, glm::dot(normal, corner) + skin_, holding};
}

/// Remembers what pushes. One surface left, and the IHIP really over it: back to the neighborhood watch, which is
/// cheaper and exact there. The planes of several triangles around one vertex are one surface too: held above all of
/// them the IHIP would stay at a saddle's vertex, where it could come nearer to the HIP above some. The watch goes on from
/// the place on the triangle that is the closest to the HIP: not where that is another place than the IHIP's, nor where
/// the skin that the solver keeps is filled by another surface.
void ContactTick::updateMode(Vec3 hip, const SolverStep& move, bool settled) noexcept {
  if (!move.done) {
    state_.holdingCount = 0;  // holding[0] stays: whom the contact belongs to
    return;
  }
  if (move.count == 0 && settled) return setFree(hip);
  std::copy_n(move.pushing.begin(), move.count, state_.holding.begin());
  state_.holdingCount = move.count;
  if (!settled) return;
  if (!isOneSurface(move) || !isWithin(kRecontactMargin, held()) || isSelfIntersecting(held())) return;
  const std::uint32_t t = held().triangle;
  const Near& near = heldNear();
  const ClosestPoint foot = closestOn(near.surface->triangle(t), t, near.frame.toLocal(hip));
  if (squaredLength(foot.point - near.from) > kTouchMargin * kTouchMargin * skin_ * skin_) return;
  if (near_.count() > 1 && tryMoveTo(near.frame.toWorld(lifted(foot.point, held(), pathOffset_)))) return;
  hold(held(), foot, near.frame.toWorld(foot.point));
}

}  // namespace haptics
