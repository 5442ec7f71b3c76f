#include <algorithm>
#include <cmath>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/nearest_foot.h"
#include "haptic_server/engine/contact/tolerances.h"
#include "haptic_server/engine/geometry/enclosure.h"

namespace haptics {
namespace {

/// The IHIP between an adoption and the next tick, on its way to a place outside of all bodies.
class Proxy {
 public:
  Proxy(Vec3 place, Vec3 outward, Allowance& allowance) noexcept
      : place_(place), outward_(outward), allowance_(allowance) {}

  [[nodiscard]] Vec3 place() const noexcept { return place_; }

  /// Off the surface that held it by a skin, so that the segment to the HIP starts outside of a new mesh of the same
  /// shape, and finds it even where the HIP is already beyond its other side.
  void lift(std::span<const Body> bodies) noexcept {
    double extent = glm::length(place_);
    for (const Body& body : bodies) {
      if (withinSphere(body)) extent = std::max(extent, body.surface->extent_m() + glm::length(body.previous.position));
    }
    place_ += outward_ * (kSkin * extent);
  }

  /// Out of the body when it is inside. Returns whether it was; false when the allowance is spent.
  bool pushOutOf(const Body& body) noexcept {
    const CollisionMesh& s = *body.surface;
    if (body.pendingRemoval || !s.closed() || !withinSphere(body)) return false;
    const Vec3 local = toLocal(body.previous, place_);
    if (windingNumber(s, local, allowance_) <= 0) return false;
    const ClosestPoint foot = nearestFoot(s, local, allowance_);
    if (allowance_.isSpent()) return false;
    const Vec3 normal = s.normal(foot);
    const Vec3 outward = glm::conjugate(body.previous.rotation) * outward_;
    const double lift = kStartOffset * (s.extent_m() + glm::length(body.previous.position));
    const bool otherSide = glm::dot(normal, outward) < 0;
    const Vec3 out =
        otherSide ? retract(s, local, outward, std::sqrt(foot.squaredDistance), lift) : foot.point + normal * lift;
    place_ = toWorld(body.previous, out);
    if (outward_ == Vec3(0)) outward_ = body.previous.rotation * normal;
    return true;
  }

  /// Out of the spheres about all bodies, in the direction in which it was pushed last.
  void escape(std::span<const Body> bodies) noexcept {
    for (int round = 0; round < kMaxReprojectionRounds; ++round) {
      for (const Body& body : bodies) {
        if (withinSphere(body)) place_ += outward_ * (2 * body.surface->radius_m());
      }
    }
  }

 private:
  [[nodiscard]] bool withinSphere(const Body& body) const noexcept {
    const Vec3 centre = toWorld(body.previous, body.surface->centre());
    const double radius = body.surface->radius_m();
    return squaredLength(place_ - centre) <= radius * radius;
  }

  /// Out on the side from which the surface was touched, though its other side is nearer (a thin shell).
  [[nodiscard]] Vec3 retract(const CollisionMesh& s, Vec3 local, Vec3 outward, double depth, double lift) noexcept {
    for (double distance = 2 * depth + lift; distance < 2 * s.radius_m(); distance *= 2) {
      const Vec3 beyond = local + outward * distance;
      if (windingNumber(s, beyond, allowance_) > 0) continue;
      const Crossing crossing = s.firstCrossing(beyond, local, allowance_);
      return crossing ? glm::mix(beyond, local, crossing.time) + outward * lift : beyond;
    }
    return local + outward * (2 * s.radius_m());
  }

  Vec3 place_;    // world, metres
  Vec3 outward_;  // unit: out of the surface that held it; zero when none did
  Allowance& allowance_;
};

/// Does the contact go on with this body?
bool isCarried(const ContactState& state, const BodyOrigin& origin) noexcept {
  return !origin.changed || (origin.dented && state.mode == ContactState::Mode::kOneSurface);
}

/// Renumbers the bodies that hold the contact. False when one of them is gone or changed.
bool renumber(ContactState& state, std::span<const BodyOrigin> origins) noexcept {
  const std::size_t count = state.surfaces().size();
  for (std::size_t i = 0; i < count; ++i) {
    const int before = state.holding[i].body;
    const auto now = std::find_if(origins.begin(), origins.end(),
                                  [&](const BodyOrigin& o) { return o.before == before && isCarried(state, o); });
    if (now == origins.end()) return false;
    state.holding[i].body = static_cast<int>(now - origins.begin());
  }
  return true;
}

/// Moves the IHIP with the triangles of a surface that was dented.
void followDented(ContactState& state, const Body& body, Allowance& allowance) noexcept {
  const CollisionMesh& s = *body.surface;
  const Vec3 h = body.frame.toLocal(state.hip);
  SearchRun run{.budget = searchBudget(allowance)};
  const auto [foot, converged] = neighborhoodWatch(s, state.holding[0].triangle, h, run);
  allowance.spend(Allowance::kNearTriangle * run.looked);
  if (converged && s.isOutside(foot, h, state.holding[0].side)) {
    const bool unchecked = state.containmentUnchecked;
    resetContact(state, state.hip);
    state.containmentUnchecked = state.unfinished = unchecked;
    return;
  }
  state.holding[0].triangle = foot.triangle;
  state.feature = foot.feature;
  state.local = foot.point;
  state.ihip = body.frame.toWorld(foot.point);
}

}  // namespace

bool reprojectContact(ContactState& state, std::span<const Body> bodies, std::span<const BodyOrigin> origins,
                      Allowance allowance) noexcept {
  const Vec3 toIhip = state.ihip - state.hip;
  const double depth = glm::length(toIhip);
  const bool held = state.mode != ContactState::Mode::kFree;
  const bool contactCarried = renumber(state, origins);
  state.clear = {};
  Proxy proxy(state.ihip, held && depth > 0 ? toIhip / depth : Vec3(0), allowance);
  if (!contactCarried) proxy.lift(bodies);
  const auto surfaces = state.surfaces();
  const int onDented =
      contactCarried && !surfaces.empty() && origins[static_cast<std::size_t>(surfaces.front().body)].dented
          ? surfaces.front().body
          : -1;
  bool pushed = false;
  bool settled = false;
  for (int round = 0; round < kMaxReprojectionRounds && !settled; ++round) {
    settled = true;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const bool suspect = (origins[i].changed && static_cast<int>(i) != onDented) || pushed;
      if (suspect && proxy.pushOutOf(bodies[i])) {
        pushed = true;
        settled = false;
      }
    }
  }
  if (allowance.isSpent()) {
    state.containmentUnchecked = state.unfinished = true;
  } else if (!settled) {
    proxy.escape(bodies);
  }
  if (contactCarried && !pushed) {
    if (onDented >= 0) followDented(state, bodies[static_cast<std::size_t>(onDented)], allowance);
    return false;
  }
  state.ihip = proxy.place();
  releaseContact(state);
  return true;
}

}  // namespace haptics
