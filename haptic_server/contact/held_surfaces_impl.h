#pragma once

// How surfaces that hold carry the IHIP on, triangle by triangle.

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic_server/contact/constraint_solver_impl.h"

namespace haptics {

/// Each body that held is followed from triangle to triangle. The planes of the triangles that hold lead to a point. On
/// the way to it one of them ends first: there the IHIP goes over to its neighbour, or, where that one rises, to where
/// both let it. Fine surfaces that hold the IHIP together are thus followed triangle by triangle, where meeting every
/// plane takes a test of the whole bodies each. All ways are tested like any other.
template <class Corrections>
typename ContactTick<Corrections>::Move ContactTick<Corrections>::followHeld(Vec3 hip) noexcept {
  constexpr int kMostHops = 16;  // what is left is met as usual
  Holding held = oneOfEachBody();
  Holding before;
  for (int i = 0; i < kMostHops; ++i) {
    Constraints constraints(hip, kSlack * skin_);
    for (const HoldingSurface& s : held.surfaces()) {
      if (!constraints.add(planeOf(s))) return {};
    }
    Vec3 to = constraints.optimum.point;
    const Carried carried = carriedBy(std::as_const(held).surfaces(), constraints);
    if (!carried.ends) return go(to) ? Move{} : constraints.move(carried.over);
    const auto next = across(held.at[carried.surface], carried.edge);
    if (!next) return {};
    if (constraints.cutOffBy(planeOf(*next))) {
      if (!constraints.add(planeOf(*next))) return {};
      to = constraints.optimum.point;
    } else if (carried.time < 1 && !isBehind()) {
      to = glm::mix(state_.ihip, to, carried.time);
    }
    if (go(to)) return {};
    const Holding hopped = held.with(carried.surface, next->triangle);
    if (hopped == before) return constraints.move();  // to and fro: the IHIP is held on the edge
    before = held;
    held = hopped;
    ++work_.triangles;
  }
  return {};
}

/// Is a moving body on its way yet? Its motion is part of the IHIP's first way, which cannot be divided in the world.
template <class Corrections>
bool ContactTick<Corrections>::isBehind() const noexcept {
  for (int i = 0; i < near_.count(); ++i) {
    const Near& near = near_[i];
    if (!bodies_[static_cast<std::size_t>(near.body)].moving) continue;
    if (squaredLength(near.frame.toLocal(state_.ihip) - near.from) > lift_ * lift_) return true;
  }
  return false;
}

/// Does the triangle across edge k leave room for the optimum, in a plane of its own?
template <class Corrections>
bool ContactTick<Corrections>::fallsAway(const HoldingSurface& s, int k,
                                         const Constraints& constraints) const noexcept {
  constexpr double kSamePlane = 1e-12;  // squared sine
  const auto next = across(s, k);
  if (!next) return false;
  const ConstraintPlane plane = planeOf(*next);
  return squaredLength(glm::cross(plane.normal, planeOf(s).normal)) > kSamePlane && !constraints.cutOffBy(plane);
}

/// What continues the side of a surface over edge k of its triangle.
template <class Corrections>
std::optional<HoldingSurface> ContactTick<Corrections>::across(const HoldingSurface& s, int k) const noexcept {
  const std::uint32_t neighbour = surface(s.body).triangle(s.triangle).neighbour(k);
  if (neighbour == kNoTriangle) return std::nullopt;
  return HoldingSurface{s.body, s.side, neighbour};
}

/// How far on the straight way to the optimum the triangles under the IHIP stay under it, and which one ends first: of
/// where both would be without the skin, which lifts them over edges. As far beyond its edge counts as over a triangle
/// as makes clear that it is left.
template <class Corrections>
typename ContactTick<Corrections>::Carried ContactTick<Corrections>::carriedBy(
    std::span<const HoldingSurface> surfaces, const Constraints& constraints) const noexcept {
  Carried carried;
  const Vec3 optimum = constraints.optimum.point;
  const Vec3 lowered = optimum - constraints.lift(skin_);
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

/// The neighborhood watch of the one surface that pushes, from where the IHIP is over it, each hop tested like any other
/// way. Returns whether it came to its end; `move` then tells what pushes there.
template <class Corrections>
bool ContactTick<Corrections>::watchOn(Vec3 hip, Move& move) noexcept {
  HoldingSurface& held = move.pushing[0];
  const Near& near = near_[near_.indexOf(held.body)];
  SearchPath path;
  const SearchResult found =
      neighborhoodWatch<Corrections>(*near.surface, held.triangle, near.frame.toLocal(hip), &path, work_.triangles);
  if (near.surface->onBoundary(found.foot)) return false;  // where the watch means nothing
  const bool whole = path.complete() && found.converged;
  if (!path.complete()) path.keepFirst(SearchPath::kCapacity);
  for (const SearchPath::Point& point : path) {
    const Vec3 above = point.place + near.surface->faceNormal(point.triangle) * (held.side * skin_);
    if (go(near.frame.toWorld(above))) return false;
    held.triangle = point.triangle;
    move.count = 1;
  }
  return whole;
}

/// Do all that push belong to one surface? So do the triangles around one vertex.
template <class Corrections>
bool ContactTick<Corrections>::isOneSurface(const Move& move) const noexcept {
  const HoldingSurface& strongest = move.pushing[0];
  return move.count > 0 && std::all_of(move.pushing.begin() + 1, move.pushing.begin() + move.count,
                                       [&](const HoldingSurface& s) { return meet(s, strongest); });
}

}  // namespace haptics
