#include "haptic_server/contact/way_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "haptic_server/contact/nearest_foot.h"
#include "haptic_server/contact/plane_set.h"

namespace haptics {
namespace {

/// Where a point is inside of a body.
struct Depth {
  double depth_m = 0;
  Vec3 foot{0};  ///< World.
  Vec3 normal{0};
};

class Bodies {
 public:
  explicit Bodies(std::span<const Body> bodies) noexcept : bodies_(bodies) {}

  /// In the body that it is the deepest in; depth 0 when in none.
  [[nodiscard]] Depth deepest(Vec3 at) const noexcept {
    Depth deepest;
    for (const Body& body : bodies_) {
      const Depth depth = depthIn(body, at);
      if (depth.depth_m > deepest.depth_m) deepest = depth;
    }
    return deepest;
  }
  [[nodiscard]] bool anyHolds(Vec3 at) const noexcept {
    return std::ranges::any_of(bodies_, [&](const Body& body) { return depthIn(body, at).depth_m > 0; });
  }

  /// The way from a place that is outside of all, as far as it does not enter.
  [[nodiscard]] double clearTime(Vec3 from, Vec3 to) const noexcept {
    double time = 1;
    for (const Body& body : bodies_) {
      if (!counts(body)) continue;
      const Crossing crossing = body.surface->firstCrossing(body.frame.toLocal(from), body.frame.toLocal(to));
      if (crossing) time = std::min(time, crossing.time);
    }
    return time;
  }

  /// Farther than this from the place there is no body.
  [[nodiscard]] double reachFrom(Vec3 place) const noexcept {
    double reach = 0;
    for (const Body& body : bodies_) {
      if (counts(body)) reach = std::max(reach, glm::distance(place, body.centre) + body.surface->radius_m());
    }
    return reach;
  }

 private:
  static bool counts(const Body& body) noexcept { return !body.leaving && body.surface->closed(); }

  static Depth depthIn(const Body& body, Vec3 at) noexcept {
    const Surface& s = *body.surface;
    if (!counts(body) || squaredLength(at - body.centre) > s.radius_m() * s.radius_m()) return {};
    const Vec3 local = body.frame.toLocal(at);
    if (glm::any(glm::lessThan(local, s.low())) || glm::any(glm::greaterThan(local, s.high()))) return {};
    const Foot foot = nearestFoot(s, local);
    if (s.isOutside(foot, local)) return {};
    return {std::sqrt(foot.squaredDistance), body.frame.toWorld(foot.point), body.frame.turn(s.normal(foot))};
  }

  std::span<const Body> bodies_;
};

/// Above the planes of all that is in the way, met one after the other. None when they leave no room.
std::optional<Vec3> abovePlanes(const Bodies& bodies, Vec3 from, double skin) noexcept {
  PlaneSet planes;
  Vec3 at = from;
  while (true) {
    const Depth inside = bodies.deepest(at);
    if (inside.depth_m == 0) return at;
    if (planes.full()) return std::nullopt;
    planes.add({inside.normal, glm::dot(inside.normal, inside.foot) + skin, {}});
    const auto nearest = planes.nearest(from, skin / 4);
    if (!nearest) return std::nullopt;
    at = nearest->point;
  }
}

/// In each direction to a place that is outside, farther and farther, and back to where that way enters; the nearest.
Vec3 throughBodies(const Bodies& bodies, Vec3 from, Vec3 outward, double skin) noexcept {
  constexpr double kThird = 0.57735026918962576;  // root of
  std::array<Vec3, 15> directions{outward, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (std::size_t i = 0; i < 8; ++i) {
    directions[7 + i] = Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1) * kThird;
  }
  constexpr int kMostDoublings = 20;
  const double reach = bodies.reachFrom(from) + skin;
  double way = std::max(2 * bodies.deepest(from).depth_m, reach / (1 << kMostDoublings));
  for (; way < reach; way *= 2) {
    std::optional<Vec3> nearest;
    for (const Vec3 direction : directions) {
      const Vec3 beyond = from + direction * way;
      if (direction == Vec3(0) || bodies.anyHolds(beyond)) continue;
      const double clear = way * bodies.clearTime(beyond, from);
      const Vec3 place = beyond - direction * std::max(clear - skin, 0.0);
      if (!nearest || glm::distance(place, from) < glm::distance(*nearest, from)) nearest = place;
    }
    if (nearest) return *nearest;
  }
  const Vec3 beyond = from + (outward == Vec3(0) ? directions[1] : outward) * reach;
  return glm::mix(beyond, from, bodies.clearTime(beyond, from) * (1 - skin / reach));
}

}  // namespace

Vec3 wayOut(std::span<const Body> bodies, Vec3 from, Vec3 outward, double skin) noexcept {
  const Bodies all(bodies);
  const auto open = abovePlanes(all, from, skin);
  return open ? *open : throughBodies(all, from, outward, skin);
}

}  // namespace haptics
