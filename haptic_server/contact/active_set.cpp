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
SolverStep ContactTick::followActiveSet(Vec3 hip) noexcept {
  constexpr int kMaxHops = 16;  // what is left is met as usual
  ActiveSet held = oneOfEachBody();
  ActiveSet before;
  for (int i = 0; i < kMaxHops && !work_.allowance.isSpent(); ++i) {
    work_.allowance.spend(Allowance::kPlanes);
    Constraints constraints(hip, skin_);
    for (const ContactSurface& s : held.surfaces()) {
      if (!constraints.add(planeOf(s))) return {};
    }
    Vec3 to = constraints.optimum.point;
    const SupportLimit limit = supportLimit(std::as_const(held).surfaces(), constraints);
    if (constraints.optimum.tightCount == ContactState::kMaxHolding && !limit.over) {
      if (const auto round = crossConvexEdge(hip, held, constraints)) {
        before = std::exchange(held, *round);
        continue;
      }
    }
    if (!limit.ends) return tryMoveTo(to) ? SolverStep{} : constraints.move(limit.over);
    const bool pushed = constraints.pushes(limit.surface);
    const auto next = across(held.at[limit.surface], limit.edge);
    if (!next) return {};
    const ActiveSet hopped = held.with(limit.surface, next->triangle);
    const bool toAndFro = hopped == before;  // the IHIP is held on the edge
    const ConstraintPlane ahead = planeOf(*next);
    const bool rises = constraints.isCutOffBy(ahead);
    if (rises && (toAndFro || hasPendingBodyMotion())) {
      if (!constraints.add(ahead)) return {};
      to = constraints.optimum.point;
    } else if (rises) {
      to = glm::mix(state_.ihip, to, ahead.reachedAt(state_.ihip, to));
    } else if (limit.time < 1 && !hasPendingBodyMotion()) {
      to = glm::mix(state_.ihip, to, limit.time);
    }
    if (tryMoveTo(to)) return {};
    if (toAndFro) {
      SolverStep move = constraints.move(true);
      resolveRidge(held, hopped, move);
      return move;
    }
    if (pushed) {
      SolverStep atEdge = onEdge(hopped, held.at[limit.surface]);
      const Vec3 edge = state_.ihip;
      if (continueWatch(hip, atEdge)) return atEdge;
      if (state_.ihip != edge) return {};
    }
    before = held;
    held = hopped;
    ++work_.triangles;
  }
  return {};
}

/// Is a moving body on its way yet? Its motion is part of the IHIP's first way, which cannot be divided in the world.
bool ContactTick::hasPendingBodyMotion() const noexcept {
  for (int i = 0; i < near_.count(); ++i) {
    const Near& near = near_[i];
    if (!bodies_[static_cast<std::size_t>(near.body)].moving) continue;
    if (squaredLength(near.frame.toLocal(state_.ihip) - near.from) > startOffset_ * startOffset_) return true;
  }
  return false;
}

/// Does the triangle across edge k leave room for the optimum, in a plane of its own?
bool ContactTick::leavesRoomAcross(const ContactSurface& s, int k, const Constraints& constraints) const noexcept {
  constexpr double kSamePlane = 1e-12;  // squared sine
  const auto next = across(s, k);
  if (!next) return false;
  const ConstraintPlane plane = planeOf(*next);
  return squaredLength(glm::cross(plane.normal, planeOf(s).normal)) > kSamePlane && !constraints.isCutOffBy(plane);
}

/// Held in a point by three: at an edge that juts out between two others it is enough to be above either of its
/// triangles. The skin parts the points in which these hold the IHIP with the two others, which are the same place of the
/// surfaces: where it would leave the other point, it is not held. Returns what holds there then.
std::optional<ActiveSet> ContactTick::crossConvexEdge(Vec3 hip, const ActiveSet& held,
                                                      const Constraints& constraints) const noexcept {
  const double nearer = glm::distance(constraints.optimum.point, hip) - kEdgeTolerance * skin_;
  for (std::size_t i = 0; i < held.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto next = across(held.at[i], k);
      if (!next || !isWithin(kRecontactMargin, *next) || !isConvexEdge(held.at[i], k)) continue;
      const ActiveSet beyond = held.with(i, next->triangle);
      Constraints there(hip, skin_);
      if (!std::ranges::all_of(beyond.surfaces(), [&](const ContactSurface& s) { return there.add(planeOf(s)); }))
        continue;
      if (there.optimum.tightCount < 3 && glm::distance(there.optimum.point, hip) < nearer) return beyond;
    }
  }
  return std::nullopt;
}

/// Does the triangle across edge k go down from it?
bool ContactTick::isConvexEdge(const ContactSurface& s, int k) const noexcept {
  const TriangleRecord& record = surface(s.body).triangle(s.triangle);
  const TriangleRecord& other = surface(s.body).triangle(record.neighbour(k));
  const int corner = other.cornerOf(record.vertexAt(nextCorner(k)));
  const Vec3 far = other.corner(nextCorner(nextCorner(corner)));
  return glm::dot(record.areaNormal(), far - record.corner(k)) * s.side < 0;
}

/// What continues the side of a surface over edge k of its triangle.
std::optional<ContactSurface> ContactTick::across(const ContactSurface& s, int k) const noexcept {
  const std::uint32_t neighbour = surface(s.body).triangle(s.triangle).neighbour(k);
  if (neighbour == kNoTriangle) return std::nullopt;
  return ContactSurface{s.body, s.side, neighbour};
}

/// How far on the straight way to the optimum the triangles under the IHIP stay under it, and which one ends first: of
/// where both would be without the skin, which lifts them over edges. As far beyond its edge counts as over a triangle
/// as makes clear that it is left.
SupportLimit ContactTick::supportLimit(std::span<const ContactSurface> surfaces,
                                       const Constraints& constraints) const noexcept {
  SupportLimit limit;
  const Vec3 optimum = constraints.optimum.point;
  const Vec3 lowered = optimum - constraints.lift();
  const double hair = kEdgeTolerance * skin_;
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
      limit.over = false;
      if (!(squaredScale > 0)) continue;
      const double scale = std::sqrt(squaredScale);
      end /= scale;
      if (end >= 0 && leavesRoomAcross(surfaces[i], k, constraints)) limit = {true, false, 1, i, k};
      const double speed = glm::dot(inward, near.frame.toLocal(optimum) - near.from) / scale;
      const double inside = end - speed;
      if (inside < -kSupportMargin * skin_ || end >= 0 || speed >= 0) continue;
      const double time = std::min((inside + kSupportMargin * skin_) / -speed, 1.0);
      if (!limit.ends || time < limit.time) limit = {true, false, time, i, k};
    }
  }
  return limit;
}

/// One triangle of each body: where a body held with two across an edge, the search finds the other.
ActiveSet ContactTick::oneOfEachBody() const noexcept {
  ActiveSet holding;
  for (const ContactSurface& s : state_.surfaces()) {
    const auto known = std::as_const(holding).surfaces();
    if (std::none_of(known.begin(), known.end(), [&](const ContactSurface& o) { return o.body == s.body; })) {
      holding.at[holding.count++] = s;
    }
  }
  return holding;
}

/// On an edge between triangles that both rise, or nearly so: which of the two pushes there is within the planes' slack.
/// The one that is under the IHIP holds it.
void ContactTick::resolveRidge(const ActiveSet& a, const ActiveSet& b, SolverStep& move) const noexcept {
  for (ContactSurface& s : std::span(move.pushing).first(static_cast<std::size_t>(move.count))) {
    if (isWithin(kSupportMargin, s)) continue;
    std::size_t i = 0;
    while (a.at[i].body != s.body) ++i;
    const ContactSurface& other = s.triangle == a.at[i].triangle ? b.at[i] : a.at[i];
    if (isWithin(kSupportMargin, other)) {
      s = other;
    } else {
      move.rests = false;
    }
  }
}

/// Gone over to the triangles that hold now, from another one.
SolverStep ContactTick::onEdge(const ActiveSet& held, const ContactSurface& left) const noexcept {
  SolverStep move{true, false, false, state_.ihip, static_cast<int>(held.count), 1, {}};
  *std::ranges::copy(held.surfaces(), move.pushing.begin()).out = left;
  return move;
}

/// Of the points nearest to the HIP of all triangles that the IHIP touches, the nearest. None when what pushes is in the
/// way there, or when, held by several surfaces, the IHIP is as near.
std::optional<ContactSurface> ContactTick::nearestTouched(Vec3 hip, const SolverStep& move) const noexcept {
  std::optional<ContactSurface> nearest;
  ClosestPoint foot;
  for (const ContactSurface& s : move.touched()) {
    if (!isWithin(kRecontactMargin, s)) continue;
    const Near& near = near_[near_.indexOf(s.body)];
    const ClosestPoint other = closestOn(near.surface->triangle(s.triangle), s.triangle, near.frame.toLocal(hip));
    if (other.squaredDistance >= foot.squaredDistance) continue;
    foot = other;
    nearest = s;
  }
  if (!nearest || (move.others == 0 && isOneSurface(move))) return nearest;
  const double nearer = glm::distance(state_.ihip, hip) - std::sqrt(foot.squaredDistance);
  if (nearer <= kRecontactMargin * skin_) return std::nullopt;
  const Vec3 place = near_[near_.indexOf(nearest->body)].frame.toWorld(lifted(foot.point, *nearest, skin_));
  const bool blocked = std::ranges::any_of(move.allPushing(), [&](const ContactSurface& s) {
    const ConstraintPlane plane = planeOf(s);
    return !shareVertex(s, *nearest) && glm::dot(plane.normal, place) < plane.offset - kConstraintTolerance * skin_;
  });
  return blocked ? std::nullopt : nearest;
}

/// The paper's rule goes before the planes' also where several surfaces hold: the neighborhood watch from where the IHIP
/// touches a triangle, each hop tested like any other way. Returns whether it came to its end; `move` then tells what
/// pushes there.
bool ContactTick::continueWatch(Vec3 hip, SolverStep& move) noexcept {
  const auto start = nearestTouched(hip, move);
  if (!start) return false;
  ContactSurface held = *start;
  const Near& near = near_[near_.indexOf(held.body)];
  SearchPath path;
  const SearchResult found = search(held, near.frame.toLocal(hip), &path);
  if (near.surface->onBoundary(found.foot)) return false;  // where the watch means nothing
  const bool whole = path.complete() && found.converged;
  if (!path.complete()) path.keepFirst(SearchPath::kCapacity);
  for (const SearchPath::Point& point : path) {
    if (work_.allowance.isSpent()) return false;
    held.triangle = point.triangle;
    if (tryMoveTo(near.frame.toWorld(lifted(point.place, held, skin_)))) return false;
    move.pushing[0] = held;
    move.count = 1;
    move.others = 0;
  }
  return whole;
}

/// Do all that push belong to one surface? So do the triangles around one vertex.
bool ContactTick::isOneSurface(const SolverStep& move) const noexcept {
  const ContactSurface& strongest = move.pushing[0];
  return move.count > 0 &&
         std::ranges::all_of(move.allPushing(), [&](const ContactSurface& s) { return shareVertex(s, strongest); });
}

}  // namespace haptics
