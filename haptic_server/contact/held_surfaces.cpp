// How surfaces that hold carry the IHIP on, triangle by triangle.

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

/// Each body that held is followed from triangle to triangle. The planes of the triangles that hold lead to a point. On
/// the way to it one of them ends first: there the IHIP goes over to its neighbour, or, where that one rises, to where
/// both let it. Fine surfaces that hold the IHIP together are thus followed triangle by triangle, where meeting every
/// plane takes a test of the whole bodies each. All ways are tested like any other.
Move ContactTick::followHeld(Vec3 hip) noexcept {
  constexpr int kMostHops = 16;  // what is left is met as usual
  Holding held = oneOfEachBody();
  Holding before;
  for (int i = 0; i < kMostHops && !work_.allowance.isSpent(); ++i) {
    work_.allowance.spend(Allowance::kPlanes);
    Constraints constraints(hip, skin_);
    for (const HoldingSurface& s : held.surfaces()) {
      if (!constraints.add(planeOf(s))) return {};
    }
    Vec3 to = constraints.optimum.point;
    const Carried carried = carriedBy(std::as_const(held).surfaces(), constraints);
    if (constraints.optimum.tightCount == ContactState::kMaxHolding && !carried.over) {
      if (const auto round = roundTheEdge(hip, held, constraints)) {
        before = std::exchange(held, *round);
        continue;
      }
    }
    if (!carried.ends) return go(to) ? Move{} : constraints.move(carried.over);
    const bool pushed = constraints.pushes(carried.surface);
    const auto next = across(held.at[carried.surface], carried.edge);
    if (!next) return {};
    const Holding hopped = held.with(carried.surface, next->triangle);
    const bool toAndFro = hopped == before;  // the IHIP is held on the edge
    const ConstraintPlane ahead = planeOf(*next);
    const bool rises = constraints.cutOffBy(ahead);
    if (rises && (toAndFro || isBehind())) {
      if (!constraints.add(ahead)) return {};
      to = constraints.optimum.point;
    } else if (rises) {
      to = glm::mix(state_.ihip, to, ahead.reachedAt(state_.ihip, to));
    } else if (carried.time < 1 && !isBehind()) {
      to = glm::mix(state_.ihip, to, carried.time);
    }
    if (go(to)) return {};
    if (toAndFro) {
      Move move = constraints.move(true);
      restBetween(held, hopped, move);
      return move;
    }
    if (pushed) {
      Move atEdge = onEdge(hopped, held.at[carried.surface]);
      const Vec3 edge = state_.ihip;
      if (watchOn(hip, atEdge)) return atEdge;
      if (state_.ihip != edge) return {};
    }
    before = held;
    held = hopped;
    ++work_.triangles;
  }
  return {};
}

/// Is a moving body on its way yet? Its motion is part of the IHIP's first way, which cannot be divided in the world.
bool ContactTick::isBehind() const noexcept {
  for (int i = 0; i < near_.count(); ++i) {
    const Near& near = near_[i];
    if (!bodies_[static_cast<std::size_t>(near.body)].moving) continue;
    if (squaredLength(near.frame.toLocal(state_.ihip) - near.from) > lift_ * lift_) return true;
  }
  return false;
}

/// Does the triangle across edge k leave room for the optimum, in a plane of its own?
bool ContactTick::fallsAway(const HoldingSurface& s, int k, const Constraints& constraints) const noexcept {
  constexpr double kSamePlane = 1e-12;  // squared sine
  const auto next = across(s, k);
  if (!next) return false;
  const ConstraintPlane plane = planeOf(*next);
  return squaredLength(glm::cross(plane.normal, planeOf(s).normal)) > kSamePlane && !constraints.cutOffBy(plane);
}

/// Held in a point by three: at an edge that juts out between two others it is enough to be above either of its
/// triangles. The skin parts the points in which these hold the IHIP with the two others, which are the same place of the
/// surfaces: where it would leave the other point, it is not held. Returns what holds there then.
std::optional<Holding> ContactTick::roundTheEdge(Vec3 hip, const Holding& held,
                                                 const Constraints& constraints) const noexcept {
  const double nearer = glm::distance(constraints.optimum.point, hip) - kHair * skin_;
  for (std::size_t i = 0; i < held.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto next = across(held.at[i], k);
      if (!next || !isWithin(kAbove, *next) || !jutsOut(held.at[i], k)) continue;
      const Holding beyond = held.with(i, next->triangle);
      Constraints there(hip, skin_);
      if (!std::ranges::all_of(beyond.surfaces(), [&](const HoldingSurface& s) { return there.add(planeOf(s)); }))
        continue;
      if (there.optimum.tightCount < 3 && glm::distance(there.optimum.point, hip) < nearer) return beyond;
    }
  }
  return std::nullopt;
}

/// Does the triangle across edge k go down from it?
bool ContactTick::jutsOut(const HoldingSurface& s, int k) const noexcept {
  const TriangleRecord& record = surface(s.body).triangle(s.triangle);
  const TriangleRecord& other = surface(s.body).triangle(record.neighbour(k));
  const int corner = other.cornerOf(record.vertexAt(nextCorner(k)));
  const Vec3 far = other.corner(nextCorner(nextCorner(corner)));
  return glm::dot(record.areaNormal(), far - record.corner(k)) * s.side < 0;
}

/// What continues the side of a surface over edge k of its triangle.
std::optional<HoldingSurface> ContactTick::across(const HoldingSurface& s, int k) const noexcept {
  const std::uint32_t neighbour = surface(s.body).triangle(s.triangle).neighbour(k);
  if (neighbour == kNoTriangle) return std::nullopt;
  return HoldingSurface{s.body, s.side, neighbour};
}

/// How far on the straight way to the optimum the triangles under the IHIP stay under it, and which one ends first: of
/// where both would be without the skin, which lifts them over edges. As far beyond its edge counts as over a triangle
/// as makes clear that it is left.
Carried ContactTick::carriedBy(std::span<const HoldingSurface> surfaces,
                               const Constraints& constraints) const noexcept {
  Carried carried;
  const Vec3 optimum = constraints.optimum.point;
  const Vec3 lowered = optimum - constraints.lift();
  const double hair = kHair * skin_;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Near& near = near_[near_.indexOf(surfaces[i].body)];
    const TriangleRecord& record = near.surface->triangle(surfaces[i].triangle);
    const Vec3 normal = record.areaNormal();
    const Vec3 to = near.frame.toLocal(lowered);
    for (int k = 0; k < 3; ++k) {
      const Vec3 inward = glm::cross(normal, record.corner(nextCorner(k)) - record.corner(k));
      const double squaredScale = squaredLength(inward);
      double end = glm::dot(inward, to - record.corner(k));
      if (end > 0 && end * end >= hair * hair * squaredScale) continue;  // nearly always
      carried.over = false;
      if (!(squaredScale > 0)) continue;
      const double scale = std::sqrt(squaredScale);
      end /= scale;
      if (end >= 0 && fallsAway(surfaces[i], k, constraints)) carried = {true, false, 1, i, k};
      const double speed = glm::dot(inward, near.frame.toLocal(optimum) - near.from) / scale;
      const double inside = end - speed;
      if (inside < -kUnder * skin_ || end >= 0 || speed >= 0) continue;
      const double time = std::min((inside + kUnder * skin_) / -speed, 1.0);
      if (!carried.ends || time < carried.time) carried = {true, false, time, i, k};
    }
  }
  return carried;
}

/// Of two triangles of one body that held, across an edge, one is enough: the search finds the other.
Holding ContactTick::oneOfEachBody() const noexcept {
  Holding holding;
  for (const HoldingSurface& s : state_.surfaces()) {
    const auto known = std::as_const(holding).surfaces();
    if (std::none_of(known.begin(), known.end(), [&](const HoldingSurface& o) { return o.body == s.body; })) {
      holding.at[holding.count++] = s;
    }
  }
  return holding;
}

/// On an edge between triangles that both rise, or nearly so: which of the two pushes there is within the planes' slack.
/// The one that is under the IHIP holds it.
void ContactTick::restBetween(const Holding& a, const Holding& b, Move& move) const noexcept {
  for (HoldingSurface& s : std::span(move.pushing).first(static_cast<std::size_t>(move.count))) {
    if (isWithin(kUnder, s)) continue;
    std::size_t i = 0;
    while (a.at[i].body != s.body) ++i;
    const HoldingSurface& other = s.triangle == a.at[i].triangle ? b.at[i] : a.at[i];
    if (isWithin(kUnder, other)) {
      s = other;
    } else {
      move.rests = false;
    }
  }
}

/// Gone over to the triangles that hold now, from another one.
Move ContactTick::onEdge(const Holding& held, const HoldingSurface& left) const noexcept {
  Move move{true, false, false, state_.ihip, static_cast<int>(held.count), 1, {}};
  *std::ranges::copy(held.surfaces(), move.pushing.begin()).out = left;
  return move;
}

/// Of the points nearest to the HIP of all triangles that the IHIP touches, the nearest. None when what pushes is in the
/// way there, or when, held by several surfaces, the IHIP is as near.
std::optional<HoldingSurface> ContactTick::nearestTouched(Vec3 hip, const Move& move) const noexcept {
  std::optional<HoldingSurface> nearest;
  Foot foot;
  for (const HoldingSurface& s : move.touched()) {
    if (!isWithin(kAbove, s)) continue;
    const Near& near = near_[near_.indexOf(s.body)];
    const Foot other = closestOn(near.surface->triangle(s.triangle), s.triangle, near.frame.toLocal(hip));
    if (other.squaredDistance >= foot.squaredDistance) continue;
    foot = other;
    nearest = s;
  }
  if (!nearest || (move.others == 0 && isOneSurface(move))) return nearest;
  const double nearer = glm::distance(state_.ihip, hip) - std::sqrt(foot.squaredDistance);
  if (nearer <= kAbove * skin_) return std::nullopt;
  const Vec3 place = near_[near_.indexOf(nearest->body)].frame.toWorld(lifted(foot.point, *nearest, skin_));
  const bool blocked = std::ranges::any_of(move.allPushing(), [&](const HoldingSurface& s) {
    const ConstraintPlane plane = planeOf(s);
    return !meet(s, *nearest) && glm::dot(plane.normal, place) < plane.offset - kSlack * skin_;
  });
  return blocked ? std::nullopt : nearest;
}

/// The paper's rule goes before the planes' also where several surfaces hold: the neighborhood watch from where the IHIP
/// touches a triangle, each hop tested like any other way. Returns whether it came to its end; `move` then tells what
/// pushes there.
bool ContactTick::watchOn(Vec3 hip, Move& move) noexcept {
  const auto start = nearestTouched(hip, move);
  if (!start) return false;
  HoldingSurface held = *start;
  const Near& near = near_[near_.indexOf(held.body)];
  SearchPath path;
  const SearchResult found = search(held, near.frame.toLocal(hip), &path);
  if (near.surface->onBoundary(found.foot)) return false;  // where the watch means nothing
  const bool whole = path.complete() && found.converged;
  if (!path.complete()) path.keepFirst(SearchPath::kCapacity);
  for (const SearchPath::Point& point : path) {
    if (work_.allowance.isSpent()) return false;
    held.triangle = point.triangle;
    if (go(near.frame.toWorld(lifted(point.place, held, skin_)))) return false;
    move.pushing[0] = held;
    move.count = 1;
    move.others = 0;
  }
  return whole;
}

/// Do all that push belong to one surface? So do the triangles around one vertex.
bool ContactTick::isOneSurface(const Move& move) const noexcept {
  const HoldingSurface& strongest = move.pushing[0];
  return move.count > 0 &&
         std::ranges::all_of(move.allPushing(), [&](const HoldingSurface& s) { return meet(s, strongest); });
}

}  // namespace haptics
