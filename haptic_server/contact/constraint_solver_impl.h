#pragma once

// Several surfaces: the IHIP held by up to three, as the god-object is (Zilles and Salisbury 1995).

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

/// Where one round of the solver came to.
template <class Corrections>
struct ContactTick<Corrections>::Move {
  bool done = false;  ///< The straight way to the optimum was clear.
  Vec3 to{0};         ///< World.
  int count = 0;      ///< Surfaces that push there, the strongest first.
  std::array<HoldingSurface, ContactState::kMaxHolding> pushing;
};

/// From one surface to the solver. The start in the contacted body's frame: off its triangle by a lift, and a little of
/// the way to the triangle's middle, which puts it above the neighbours across a valley too. Other bodies' frames keep
/// theirs.
template <class Corrections>
void ContactTick<Corrections>::resolve(Vec3 hip) noexcept {
  // From the largest pull that crosses no fold of the own mesh, in steps of 8.
  constexpr double kPull = 0x1p-10;
  constexpr double kLeastPull = 0x1p-20;
  Near& own = heldNear();
  const Surface& s = *own.surface;
  const std::uint32_t t = held().triangle;
  const TriangleRecord& record = s.triangle(t);
  const Vec3 middle = (record.corner(0) + record.corner(1) + record.corner(2)) * (1 / 3.0);
  Vec3 inner = state_.local;
  for (double pull = kPull; pull > kLeastPull; pull /= 8) {
    inner = glm::mix(state_.local, middle, pull);
    if (!record.crossed() || clearOfOwnFolds(s, t, state_.local, inner)) break;
  }
  own.from = inner + s.faceNormal(t) * (held().side * lift_);
  state_.ihip = own.frame.toWorld(own.from);
  solve(hip);
}

/// One surface only (kSeveralSurfaces off).
template <class Corrections>
void ContactTick<Corrections>::stay() noexcept {
  Foot foot;
  foot.triangle = held().triangle;
  foot.point = state_.local;
  hold(held(), foot, heldNear().frame.toWorld(foot.point));
}

/// The IHIP moves straight to the point nearest to the HIP above all planes met so far; each blocked attempt adds the
/// plane that blocked it. When a move succeeds the planes are forgotten and met again from the new place: that is what
/// releases them.
/// A pocket that moving bodies close entirely has no place for the IHIP: it is then let through one of them.
template <class Corrections>
void ContactTick<Corrections>::solve(Vec3 hip) noexcept {
  state_.mode = Mode::kSeveralSurfaces;
  Move last;
  bool settled = false;
  for (int round = 0; round < kMaxSolverRounds && !settled; ++round) {
    ++work_.solverRounds;
    const Move move = moveTowards(hip);
    if (!move.done) break;
    settled = move.count == 0 || restsOn(move) ||
              squaredLength(move.to - state_.ihip) <= kSettled * kSettled * squaredLength(move.to - hip);
    state_.ihip = move.to;
    last = move;
  }
  work_.unsettled = work_.unsettled || !settled;
  classify(hip, last, settled);
}
template <class Corrections>
typename ContactTick<Corrections>::Move ContactTick<Corrections>::moveTowards(Vec3 hip) noexcept {
  constexpr double kSlack = 0x1p-2;  // of the skin: a plane is held when the point is not farther below it
  PlaneSet planes;
  while (true) {
    const std::optional<PlaneSet::Nearest> optimum = planes.nearest(hip, kSlack * skin_);
    if (!optimum) return {};
    const Points to = near_.inEachFrame(optimum->point);
    const Hit hit = near_.template firstHit<SegmentTest>(
        to, [](int, std::uint32_t) noexcept { return false; }, work_);
    if (!hit) {
      near_.moveAll(to, 1);
      Move move{true, optimum->point, optimum->tightCount, {}};
      for (std::size_t i = 0; i < static_cast<std::size_t>(move.count); ++i) {
        move.pushing[i] = planes[optimum->tight[i]].surface;
      }
      return move;
    }
    if (planes.full()) return {};
    planes.add(planeOf(near_[hit.near], hit.crossing));
  }
}

/// The pushing triangles are really under the IHIP, not only their planes: the planes' optimum is a local optimum.
template <class Corrections>
bool ContactTick<Corrections>::restsOn(const Move& move) const noexcept {
  return std::all_of(move.pushing.begin(), move.pushing.begin() + move.count, [&](const HoldingSurface& s) {
    const Foot foot = closestOn(surface(s.body).triangle(s.triangle), s.triangle, near_[near_.indexOf(s.body)].from);
    return foot.squaredDistance <= 4 * skin_ * skin_;
  });
}

template <class Corrections>
ConstraintPlane ContactTick<Corrections>::planeOf(const Near& near, const Crossing& crossing) const noexcept {
  const Vec3 normal = near.frame.turn(near.surface->faceNormal(crossing.triangle) * static_cast<double>(crossing.side));
  const Vec3 corner = near.frame.toWorld(near.surface->triangle(crossing.triangle).corner(0));
  return {normal, glm::dot(normal, corner) + skin_, {near.body, crossing.side, crossing.triangle}};
}

/// Remembers what pushes. One surface left, and the IHIP really over it: back to the neighborhood watch, which is
/// cheaper and exact there.
template <class Corrections>
void ContactTick<Corrections>::classify(Vec3 hip, const Move& move, bool settled) noexcept {
  if (!move.done) {
    state_.holdingCount = 0;  // holding[0] stays: whom the contact belongs to
    return;
  }
  if (move.count == 0 && settled) return setFree(hip);
  std::copy_n(move.pushing.begin(), move.count, state_.holding.begin());
  state_.holdingCount = move.count;
  if (move.count != 1 || !settled) return;
  const HoldingSurface only = held();
  const Vec3 at = heldNear().from;
  const Foot foot = closestOn(surface(only.body).triangle(only.triangle), only.triangle, at);
  if (foot.squaredDistance <= 16 * skin_ * skin_) hold(only, foot, state_.ihip);
}

}  // namespace haptics
