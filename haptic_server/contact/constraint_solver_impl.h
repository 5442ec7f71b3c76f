#pragma once

// Several surfaces: the IHIP held by up to three, as the god-object is (Zilles and Salisbury 1995).

#include <algorithm>
#include <utility>

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

/// Where the solver came to.
template <class Corrections>
struct ContactTick<Corrections>::Move {
  bool done = false;  ///< The way to the optimum was clear.
  Vec3 to{0};         ///< World.
  int count = 0;      ///< Surfaces that push there, the strongest first.
  std::array<HoldingSurface, ContactState::kMaxHolding> pushing;
};

/// A triangle of each body that holds.
template <class Corrections>
struct ContactTick<Corrections>::Holding {
  std::array<HoldingSurface, ContactState::kMaxHolding> at;
  std::size_t count = 0;

  [[nodiscard]] std::span<HoldingSurface> surfaces() noexcept { return std::span(at).first(count); }
  [[nodiscard]] std::span<const HoldingSurface> surfaces() const noexcept { return std::span(at).first(count); }
  friend bool operator==(const Holding& a, const Holding& b) noexcept {
    return std::ranges::equal(a.surfaces(), b.surfaces(), {}, &HoldingSurface::triangle, &HoldingSurface::triangle);
  }
};

/// The planes met so far, and where they let the IHIP come.
template <class Corrections>
struct ContactTick<Corrections>::Constraints {
  PlaneSet planes;
  PlaneSet::Nearest optimum;

  Constraints(Vec3 hip, double slack) noexcept : hip_(hip), slack_(slack) { optimum.point = hip; }
  /// False when there is no place above all planes.
  [[nodiscard]] bool add(const ConstraintPlane& plane) noexcept {
    if (planes.full()) return false;
    planes.add(plane);
    if (glm::dot(plane.normal, optimum.point) >= plane.offset) return true;
    const std::optional<PlaneSet::Nearest> nearest = planes.nearest(hip_, slack_);
    if (nearest) optimum = *nearest;
    return nearest.has_value();
  }

  /// To the optimum.
  [[nodiscard]] Move move() const noexcept {
    Move move{true, optimum.point, optimum.tightCount, {}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(move.count); ++i) {
      move.pushing[i] = planes[optimum.tight[i]].surface;
    }
    return move;
  }

 private:
  Vec3 hip_;      // world
  double slack_;  // m
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
/// plane that blocked it. Before that it is tried to carry the surfaces on that held. When a move does not settle the
/// planes are forgotten and met anew from the new place, which is what releases them.
/// A pocket that moving bodies close entirely has no place for the IHIP: it is then let through one of them.
template <class Corrections>
void ContactTick<Corrections>::solve(Vec3 hip) noexcept {
  Move last;
  if (state_.mode == Mode::kSeveralSurfaces && state_.holdingCount > 0) last = followHeld(hip);
  state_.mode = Mode::kSeveralSurfaces;
  bool settled = last.done && restsOn(last);
  for (int round = 0; round < kMaxSolverRounds && !settled; ++round) {
    ++work_.solverRounds;
    const Vec3 from = state_.ihip;
    const Move move = moveTowards(hip);
    if (!move.done) break;
    settled = move.count == 0 || restsOn(move) ||
              squaredLength(move.to - from) <= kSettled * kSettled * squaredLength(move.to - hip);
    last = move;
  }
  work_.unsettled = work_.unsettled || !settled;
  classify(hip, last, settled);
}

/// A neighborhood watch on each body that held. The planes of the triangles that hold lead to a point; where it is no
/// longer over one of them, the search hops from that triangle, and the IHIP moves to where the planes of both let it,
/// over the edge between them. Fine surfaces that hold the IHIP together are thus followed triangle by triangle, where
/// meeting every plane takes a test of the whole bodies each. All ways are tested like any other.
template <class Corrections>
typename ContactTick<Corrections>::Move ContactTick<Corrections>::followHeld(Vec3 hip) noexcept {
  constexpr int kMostHops = 8;  // what is left is met as usual
  Holding held = oneOfEachBody();
  Holding before;
  for (int i = 0; i < kMostHops; ++i) {
    Constraints constraints(hip, kSlack * skin_);
    if (!add(held, {}, constraints)) return {};
    Holding next = held;
    if (!hopUnder(constraints.optimum.point, next)) return {};
    if (next == held) return go(constraints.optimum.point) ? Move{} : constraints.move();
    if (!add(next, held, constraints) || go(constraints.optimum.point)) return {};
    if (next == before) return constraints.move();  // to and fro: the IHIP is held on the edge
    before = held;
    held = next;
  }
  return {};
}

/// The planes of a holding, but for those that another has.
template <class Corrections>
bool ContactTick<Corrections>::add(const Holding& holding, const Holding& known,
                                   Constraints& constraints) const noexcept {
  for (std::size_t i = 0; i < holding.count; ++i) {
    const bool isKnown = i < known.count && known.at[i].triangle == holding.at[i].triangle;
    if (!isKnown && !constraints.add(planeOf(holding.at[i]))) return false;
  }
  return true;
}

/// From the first triangle that is not under the point to the one of its body that is: one body at a time keeps to the
/// groove. False when that one is not near.
template <class Corrections>
bool ContactTick<Corrections>::hopUnder(Vec3 point, Holding& holding) noexcept {
  constexpr int kNear = 32;  // triangles looked at: a few fans
  for (HoldingSurface& s : holding.surfaces()) {
    const Surface& mesh = surface(s.body);
    const Vec3 at = near_[near_.indexOf(s.body)].frame.toLocal(point);
    const Foot start = closestOn(mesh.triangle(s.triangle), s.triangle, at);
    if (isUnder(start)) continue;
    int looked = 0;
    s.triangle = neighborhoodWatch<Corrections>(mesh, start, at, nullptr, looked).foot.triangle;
    work_.triangles += looked;
    return looked <= kNear;
  }
  return true;
}

/// Of two triangles of one body that held, across an edge, one is enough: the search finds the other.
template <class Corrections>
typename ContactTick<Corrections>::Holding ContactTick<Corrections>::oneOfEachBody() const noexcept {
  Holding holding;
  for (const HoldingSurface& s : state_.surfaces()) {
    const auto known = std::as_const(holding).surfaces();
    if (std::none_of(known.begin(), known.end(), [&](const HoldingSurface& o) { return o.body == s.body; })) {
      holding.at[holding.count++] = s;
    }
  }
  return holding;
}

template <class Corrections>
typename ContactTick<Corrections>::Move ContactTick<Corrections>::moveTowards(Vec3 hip) noexcept {
  Constraints constraints(hip, kSlack * skin_);
  while (const Hit hit = go(constraints.optimum.point)) {
    const HoldingSurface blocking{near_[hit.near].body, hit.crossing.side, hit.crossing.triangle};
    if (!constraints.add(planeOf(blocking))) return {};
  }
  return constraints.move();
}

template <class Corrections>
bool ContactTick<Corrections>::meet(const HoldingSurface& a, const HoldingSurface& b) const noexcept {
  if (a.body != b.body) return false;
  const TriangleRecord& one = surface(a.body).triangle(a.triangle);
  const TriangleRecord& other = surface(a.body).triangle(b.triangle);
  return other.cornerOf(one.vertexAt(0)) >= 0 || other.cornerOf(one.vertexAt(1)) >= 0 ||
         other.cornerOf(one.vertexAt(2)) >= 0;
}

/// Straight to a place in the world, unless something is in the way.
template <class Corrections>
typename ContactTick<Corrections>::Hit ContactTick<Corrections>::go(Vec3 world) noexcept {
  const Points to = near_.inEachFrame(world);
  const Hit hit = near_.template firstHit<SegmentTest>(
      to, [](int, std::uint32_t) noexcept { return false; }, work_);
  if (hit) return hit;
  near_.moveAll(to, 1);
  state_.ihip = world;
  return hit;
}

/// The pushing triangles are really under the IHIP, not only their planes: the planes' optimum is a local optimum.
template <class Corrections>
bool ContactTick<Corrections>::restsOn(const Move& move) const noexcept {
  return std::all_of(move.pushing.begin(), move.pushing.begin() + move.count, [&](const HoldingSurface& s) {
    return isUnder(closestOn(surface(s.body).triangle(s.triangle), s.triangle, near_[near_.indexOf(s.body)].from));
  });
}

template <class Corrections>
ConstraintPlane ContactTick<Corrections>::planeOf(const HoldingSurface& holding) const noexcept {
  const Near& near = near_[near_.indexOf(holding.body)];
  const Vec3 normal = near.frame.turn(near.surface->faceNormal(holding.triangle) * static_cast<double>(holding.side));
  const Vec3 corner = near.frame.toWorld(near.surface->triangle(holding.triangle).corner(0));
  return {normal, glm::dot(normal, corner) + skin_, holding};
}

/// Remembers what pushes. One surface left, and the IHIP really over it: back to the neighborhood watch, which is
/// cheaper and exact there. The planes of several triangles around one vertex are one surface too: held above all of
/// them the IHIP would stay at a saddle's vertex, where it could come nearer to the HIP above some.
template <class Corrections>
void ContactTick<Corrections>::classify(Vec3 hip, const Move& move, bool settled) noexcept {
  if (!move.done) {
    state_.holdingCount = 0;  // holding[0] stays: whom the contact belongs to
    return;
  }
  if (move.count == 0 && settled) return setFree(hip);
  std::copy_n(move.pushing.begin(), move.count, state_.holding.begin());
  state_.holdingCount = move.count;
  if (!settled) return;
  const HoldingSurface strongest = held();
  const Surface& mesh = surface(strongest.body);
  const bool oneFan = std::all_of(move.pushing.begin() + 1, move.pushing.begin() + move.count,
                                  [&](const HoldingSurface& s) { return !mesh.anyCrossed() && meet(s, strongest); });
  if (!oneFan) return;
  const Foot foot = closestOn(mesh.triangle(strongest.triangle), strongest.triangle, heldNear().from);
  if (foot.squaredDistance <= 16 * skin_ * skin_) hold(strongest, foot, state_.ihip);
}

}  // namespace haptics
