#include "haptic_server/engine/contact/active_set.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/contact/plane_solver.h"
#include "haptic_server/engine/contact/surface_walk.h"

namespace haptics {
namespace {

bool shareVertex(const TickContext& tick, const ContactSurface& a, const ContactSurface& b) noexcept {
  if (a.body != b.body) return false;
  const TriangleRecord& one = tick.surface(a.body).triangle(a.triangle);
  const TriangleRecord& other = tick.surface(a.body).triangle(b.triangle);
  return other.cornerOf(one.vertexAt(0)) >= 0 || other.cornerOf(one.vertexAt(1)) >= 0 ||
         other.cornerOf(one.vertexAt(2)) >= 0;
}

/// Does the triangle across edge k leave room for the optimum, in a plane of its own?
bool leavesRoomAcross(const TickContext& tick, const ContactSurface& s, int k,
                      const Constraints& constraints) noexcept {
  constexpr double kSamePlane = 1e-12;  // squared sine
  const auto next = across(tick, s, k);
  if (!next) return false;
  const ConstraintPlane plane = planeOf(tick, *next);
  return squaredLength(glm::cross(plane.normal, planeOf(tick, s).normal)) > kSamePlane &&
         !constraints.isCutOffBy(plane);
}

/// Does the triangle across edge k go down from it?
bool isConvexEdge(const TickContext& tick, const ContactSurface& s, int k) noexcept {
  const CollisionMesh& surface = tick.surface(s.body);
  const TriangleRecord& record = surface.triangle(s.triangle);
  const TriangleRecord& other = surface.triangle(record.neighbour(k));
  const int corner = other.cornerOf(record.vertexAt(nextCorner(k)));
  const Vec3 far = other.corner(nextCorner(nextCorner(corner)));
  return glm::dot(record.areaNormal(), far - record.corner(k)) * s.side < 0;
}

/// Does the surface bend away over edge k, or end there?
bool bendsAway(const CollisionMesh& surface, std::uint32_t triangle, int k) noexcept {
  const std::uint32_t next = surface.triangle(triangle).neighbour(k);
  return next == kNoTriangle || glm::dot(surface.faceNormal(triangle), surface.faceNormal(next)) <= kBend;
}

/// Held in a point by three: at an edge that juts out between two others it is enough to be above either of its
/// triangles. The skin parts the points in which these hold the IHIP with the two others, which are the same place of
/// the surfaces: where it would leave the other point, it is not held. Returns the active set beyond the edge.
std::optional<ActiveSet> crossConvexEdge(const TickContext& tick, Vec3 hip, const ActiveSet& held,
                                         const Constraints& constraints) noexcept {
  const double nearer = glm::distance(constraints.optimum.point, hip) - kEdgeTolerance * tick.skin;
  for (std::size_t i = 0; i < held.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto next = across(tick, held.at[i], k);
      if (!next || !isWithin(tick, kRecontactMargin, *next) || !isConvexEdge(tick, held.at[i], k)) continue;
      const ActiveSet beyond = held.with(i, next->triangle);
      Constraints there(hip, tick.skin);
      const auto add = [&](const ContactSurface& s) noexcept { return there.add(planeOf(tick, s)); };
      if (!std::ranges::all_of(beyond.surfaces(), add)) continue;
      if (there.optimum.tightCount < 3 && glm::distance(there.optimum.point, hip) < nearer) return beyond;
    }
  }
  return std::nullopt;
}

/// On an edge between triangles that both rise, or nearly so: which of the two pushes there is within the planes'
/// slack. The one that is under the IHIP holds it.
void resolveRidge(const TickContext& tick, const ActiveSet& a, const ActiveSet& b, SolverStep& step) noexcept {
  for (ContactSurface& s : std::span(step.surfaces).first(static_cast<std::size_t>(step.pushingCount))) {
    if (isWithin(tick, kSupportMargin, s)) continue;
    std::size_t i = 0;
    const auto isThis = [&](const ContactSurface& other) {
      return other.body == s.body && other.triangle == s.triangle;
    };
    while (!isThis(a.at[i]) && !isThis(b.at[i])) ++i;
    const ContactSurface& other = s.triangle == a.at[i].triangle ? b.at[i] : a.at[i];
    if (isWithin(tick, kSupportMargin, other)) {
      s = other;
    } else {
      step.supportKnown = false;
    }
  }
}

/// On the edge over which the IHIP leaves a surface for the active set.
SolverStep stepToEdge(const ContactState& state, const ActiveSet& held, const ContactSurface& left) noexcept {
  SolverStep step{
      .done = true, .to = state.ihip, .pushingCount = static_cast<int>(held.count), .touchedCount = 1, .surfaces = {}};
  *std::ranges::copy(held.surfaces(), step.surfaces.begin()).out = left;
  return step;
}

/// The end of a move over the edge at which a triangle's support ends, with the plane `ahead` of the triangle beyond: above
/// both planes where both hold the IHIP, at the rising one, or on the edge. None when both leave no place. A body's motion that
/// is pending has to be completed: the move then goes to the optimum.
std::optional<Vec3> endOverEdge(const TickContext& tick, const SupportLimit& limit, const ConstraintPlane& ahead,
                                bool bothHold, Constraints& constraints) noexcept {
  const Vec3 from = tick.state.ihip;
  const Vec3 optimum = constraints.optimum.point;
  if (!constraints.isCutOffBy(ahead)) {
    return limit.time < 1 && !hasPendingBodyMotion(tick) ? glm::mix(from, optimum, limit.time) : optimum;
  }
  if (!bothHold && !hasPendingBodyMotion(tick)) return glm::mix(from, optimum, ahead.reachedAt(from, optimum));
  if (!constraints.add(ahead)) return std::nullopt;
  return constraints.optimum.point;
}

/// The nearest to the HIP of all triangles that the IHIP touches. None when a surface that pushes blocks its foot, or
/// when, held by several surfaces, the IHIP is as near.
std::optional<ContactSurface> nearestTouched(const TickContext& tick, Vec3 hip, const SolverStep& step) noexcept {
  std::optional<ContactSurface> nearest;
  ClosestPoint foot;
  for (const ContactSurface& s : step.pushingOrTouched()) {
    if (!isWithin(tick, kRecontactMargin, s)) continue;
    const NearBodies::Near& near = tick.nearOf(s);
    const ClosestPoint other = closestOn(near.surface->triangle(s.triangle), s.triangle, near.frame.toLocal(hip));
    if (other.squaredDistance >= foot.squaredDistance) continue;
    foot = other;
    nearest = s;
  }
  if (!nearest || (step.touchedCount == 0 && isOneSurface(tick, step))) return nearest;
  const double nearer = glm::distance(tick.state.ihip, hip) - std::sqrt(foot.squaredDistance);
  if (nearer <= kRecontactMargin * tick.skin) return std::nullopt;
  const Vec3 place = tick.nearOf(*nearest).frame.toWorld(tick.lifted(foot.point, *nearest, tick.skin));
  const bool blocked = std::ranges::any_of(step.pushing(), [&](const ContactSurface& s) {
    const ConstraintPlane plane = planeOf(tick, s);
    return !shareVertex(tick, s, *nearest) &&
           glm::dot(plane.normal, place) < plane.offset - kConstraintTolerance * tick.skin;
  });
  return blocked ? std::nullopt : nearest;
}

}  // namespace

/// The planes of the triangles that hold lead to a point. On the way to it one of them ends first: there the IHIP goes
/// over to its neighbour, or, where that one rises, to where both let it. Fine surfaces that hold the IHIP together are
/// thus followed triangle by triangle, where meeting every plane takes a test of the whole bodies each. All moves are
/// tested.
SolverStep followActiveSet(TickContext& tick, Vec3 hip) noexcept {
  constexpr int kMaxHops = 16;  // the solver meets the rest
  const Vec3& ihip = tick.state.ihip;
  ActiveSet held = heldSurfaces(tick);
  ActiveSet before;
  std::array<ConstraintPlane, ContactState::kMaxHolding> planes;  // of `held`
  const auto findPlanes = [&] {
    std::ranges::transform(held.surfaces(), planes.begin(), [&](const ContactSurface& s) { return planeOf(tick, s); });
  };
  findPlanes();
  for (int i = 0; i < kMaxHops && !tick.work.allowance.isSpent(); ++i) {
    tick.work.allowance.spend(Allowance::kPlanes);
    Constraints constraints(hip, tick.skin);
    for (std::size_t k = 0; k < held.count; ++k) {
      if (!constraints.add(planes[k])) return {};
    }
    const SupportLimit limit = supportLimit(tick, held.surfaces(), constraints);
    if (constraints.optimum.tightCount == ContactState::kMaxHolding && !limit.insideSupport) {
      if (const auto beyond = crossConvexEdge(tick, hip, held, constraints)) {
        before = std::exchange(held, *beyond);
        findPlanes();
        continue;
      }
    }
    if (!limit.ends) {
      SolverStep step = constraints.stepToOptimum();
      if (tryMoveTo(tick, step.to)) return {};
      step.supportKnown = limit.insideSupport;
      return step;
    }
    const bool pushed = constraints.pushes(limit.surface);
    const auto next = across(tick, held.at[limit.surface], limit.edge);
    if (!next) return {};
    const ActiveSet nextSet = held.with(limit.surface, next->triangle);
    const bool oscillates = nextSet == before;  // the IHIP is held on the edge
    const ConstraintPlane ahead = planeOf(tick, *next);
    const auto end = endOverEdge(tick, limit, ahead, oscillates, constraints);
    if (!end || tryMoveTo(tick, *end)) return {};
    if (oscillates) {
      SolverStep step = constraints.stepToOptimum();
      step.supportKnown = true;
      resolveRidge(tick, held, nextSet, step);
      return step;
    }
    if (pushed) {
      SolverStep atEdge = stepToEdge(tick.state, nextSet, held.at[limit.surface]);
      const Vec3 edge = ihip;
      if (continueWatch(tick, hip, atEdge) == Watch::kEnded) return atEdge;
      if (ihip != edge) return {};
    }
    before = held;
    held = nextSet;
    planes[limit.surface] = ahead;
    ++tick.work.triangles;
  }
  return {};
}

/// The paper's rule goes before the planes' also where several surfaces hold. Each hop is tested like any other move.
Watch continueWatch(TickContext& tick, Vec3 hip, SolverStep& step) noexcept {
  const auto start = nearestTouched(tick, hip, step);
  if (!start) return Watch::kNone;
  ContactSurface held = *start;
  const NearBodies::Near& near = tick.nearOf(held);
  SearchPath path;
  const SearchResult found = search(tick, held, near.frame.toLocal(hip), &path);
  if (near.surface->onBoundary(found.foot)) return Watch::kNone;  // where the watch means nothing
  const bool reachesFoot = path.complete() && found.converged;
  if (!path.complete()) path.keepFirst(SearchPath::kCapacity);
  for (const SearchPath::Point& point : path) {
    if (tick.work.allowance.isSpent()) return Watch::kNone;
    held.triangle = point.triangle;
    if (tryMoveTo(tick, near.frame.toWorld(tick.lifted(point.place, held, tick.skin)))) return Watch::kBlocked;
    step.surfaces[0] = held;
    step.pushingCount = 1;
    step.touchedCount = 0;
  }
  return reachesFoot ? Watch::kEnded : Watch::kNone;
}

NearBodies::Hit tryMoveTo(TickContext& tick, Vec3 world) noexcept {
  const NearBodies::Points to = tick.near.inEachFrame(world);
  const NearBodies::Hit hit = tick.near.firstHit(
      to, [](int, std::uint32_t) noexcept { return false; }, tick.work);
  if (hit) return hit;
  tick.near.moveAll(to, 1);
  tick.state.ihip = world;
  return hit;
}

ConstraintPlane planeOf(const TickContext& tick, const ContactSurface& s) noexcept {
  const NearBodies::Near& near = tick.nearOf(s);
  const Vec3 normal = near.frame.rotate(near.surface->faceNormal(s.triangle) * static_cast<double>(s.side));
  const Vec3 corner = near.frame.toWorld(near.surface->triangle(s.triangle).corner(0));
  return {normal, glm::dot(normal, corner) + tick.skin, s};
}

bool isWithin(const TickContext& tick, double skins, const ContactSurface& s) noexcept {
  const ClosestPoint foot = closestOn(tick.surface(s.body).triangle(s.triangle), s.triangle, tick.nearOf(s).from);
  return foot.squaredDistance <= skins * skins * tick.skin * tick.skin;
}

bool isOneSurface(const TickContext& tick, const SolverStep& step) noexcept {
  const ContactSurface& strongest = step.surfaces[0];
  return step.pushingCount > 0 &&
         std::ranges::all_of(step.pushing(), [&](const ContactSurface& s) { return shareVertex(tick, s, strongest); });
}

/// Where one held with two triangles across an edge, the search finds the other.
ActiveSet heldSurfaces(const TickContext& tick) noexcept {
  ActiveSet holding;
  for (const ContactSurface& s : tick.state.surfaces()) {
    const bool known = std::ranges::any_of(holding.surfaces(),
                                           [&](const ContactSurface& other) { return shareVertex(tick, other, s); });
    if (!known) holding.at[holding.count++] = s;
  }
  return holding;
}

std::optional<ContactSurface> across(const TickContext& tick, const ContactSurface& s, int k) noexcept {
  const std::uint32_t neighbour = tick.surface(s.body).triangle(s.triangle).neighbour(k);
  if (neighbour == kNoTriangle) return std::nullopt;
  return ContactSurface{s.body, s.side, neighbour};
}

/// Both ends of the move as they would be without the skin, which lifts them over edges. As far beyond its edge counts
/// as over a triangle as makes clear that it is left; at an edge that bends away, to within rounding, what is beyond it may
/// have room: the side of what is flush but for rounding is no step.
SupportLimit supportLimit(const TickContext& tick, std::span<const ContactSurface> surfaces,
                          const Constraints& constraints) noexcept {
  SupportLimit limit;
  const Vec3 optimum = constraints.optimum.point;
  const Vec3 lowered = optimum - constraints.lift();
  const double edgeTolerance_m = kEdgeTolerance * tick.skin;
  const double rounding_m = kDepthTolerance * tick.skin;
  const Double4 squaredRounding = broadcast(rounding_m * rounding_m);
  const double supportMargin_m = kSupportMargin * tick.skin;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const NearBodies::Near& near = tick.nearOf(surfaces[i]);
    const TriangleRecord& record = near.surface->triangle(surfaces[i].triangle);
    const Prism prism(record);
    const Double4 ends = prism.coordinates(broadcast(near.frame.toLocal(lowered))).scaledDistance;
    const Double4 squaredScales = squaredLength(prism.normals());
    const unsigned within = (ends > broadcast(0)).bits() & (ends * ends >= squaredRounding * squaredScales).bits();
    for (int k = 0; k < 3; ++k) {
      if ((within >> k & 1) != 0) continue;  // nearly always
      const double squaredScale = squaredScales[k];
      double end = ends[k];
      const auto bends = [&]() noexcept { return bendsAway(*near.surface, surfaces[i].triangle, k); };
      if (end > 0 && end * end >= edgeTolerance_m * edgeTolerance_m * squaredScale && !bends()) continue;
      limit.insideSupport = false;
      if (!(squaredScale > 0)) continue;
      const double scale = std::sqrt(squaredScale);
      end /= scale;
      const auto endAt = [&](double time) noexcept {
        limit = {.ends = true, .insideSupport = false, .time = time, .surface = i, .edge = k};
      };
      const bool isOnEdge = end >= 0 || (end >= -rounding_m && bends());
      if (isOnEdge && leavesRoomAcross(tick, surfaces[i], k, constraints)) endAt(1);
      const double speed = glm::dot(prism.normals()[k], near.frame.toLocal(optimum) - near.from) / scale;
      const double inside = end - speed;
      if (inside < -supportMargin_m || end >= 0 || speed >= 0) continue;
      const double time = std::min((inside + supportMargin_m) / -speed, 1.0);
      // A gap may be there, and be closed.
      if (time == 1 && bends()) continue;
      if (!limit.ends || time < limit.time) endAt(time);
    }
  }
  return limit;
}

bool hasPendingBodyMotion(const TickContext& tick) noexcept {
  for (int i = 0; i < tick.near.count(); ++i) {
    const NearBodies::Near& near = tick.near[i];
    if (!tick.body(near.body).moving) continue;
    const double startOffset2 = tick.startOffset * tick.startOffset;
    if (squaredLength(near.frame.toLocal(tick.state.ihip) - near.from) > startOffset2) return true;
  }
  return false;
}

}  // namespace haptics
