#include "haptic_server/contact/fast_path/clearance.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/geometry/enclosure.h"

namespace haptics {
namespace {

/// Steps of the HIP for which a clearance has to last, and beyond which nobody looks. Fewer would be asked for again and
/// again, more are seldom made in one direction.
constexpr double kMinSteps = 8;
constexpr double kMaxClearanceSteps = 512;
/// A HIP that stands still counts as one that goes so far in a tick.
constexpr double kMinStep_m = 1e-5;
/// Ticks before it is asked for again where it was too small: twice as many each time.
constexpr std::uint16_t kFirstPause = 8;
constexpr std::uint16_t kLongestPause = 256;
/// The part of a clearance that is certain: rounding may have added the rest.
constexpr double kSure = 1 - 0x1p-18;
/// What is found of the squared distance, at least: a fine surface seen from afar has many triangles that are nearly the
/// nearest, and the search leaves them out.
constexpr double kShareFound = 0.64;

/// That no point of a body has gone farther than from the last tick to this one (m).
[[nodiscard]] double motionOf(const Body& body) noexcept {
  const Quat turn = body.current.rotation * glm::conjugate(body.previous.rotation);
  const double way = glm::distance(toWorld(body.previous, body.surface->centre()), body.centre);
  return way + 2 * body.surface->radius_m() * glm::length(Vec3(turn.x, turn.y, turn.z));
}

/// At most the squared distance from h (body frame) to the nearest triangle, and at least kShareFound of it; `bound` where
/// that is less; m^2. Not looked for any farther once it is below `least`.
[[nodiscard]] double withinNearest2(const CollisionMesh& surface, Vec3 h, double bound, double least,
                                    Allowance& allowance) noexcept {
  surface.hierarchy().visitNear(
      h, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t) {
          bound = std::min(bound, kShareFound * closestOn(surface.triangle(t), t, h).squaredDistance);
        }
        return bound < least ? -1.0 : bound;
      },
      bound);
  return bound;
}

}  // namespace

bool staysClear(std::span<const Body> bodies, ContactState& state, const Vec3& hip) noexcept {
  double most = 0;
  for (const Body& body : bodies) {
    if (body.moving) [[unlikely]]
      most = std::max(most, motionOf(body));
  }
  Clearance& clear = state.clear;
  clear.radius_m -= most;
  if (clear.radius_m > 0 && squaredLength(hip - clear.centre) < clear.radius_m * clear.radius_m) return true;
  clear.radius_m = 0;
  return false;
}

void lookForClearance(std::span<const Body> bodies, ContactState& state, double step_m, Allowance& allowance) noexcept {
  Clearance& clear = state.clear;
  if (clear.pause > 0) {
    --clear.pause;
    return;
  }
  const double step = std::max(step_m, kMinStep_m);
  const double least2 = kMinSteps * step * (kMinSteps * step);
  double near2 = kMaxClearanceSteps * step * (kMaxClearanceSteps * step);
  for (const Body& body : bodies) {
    const Vec3 h = body.frame.toLocal(state.hip);
    const CollisionMesh& s = *body.surface;
    const double gap2 = squaredLength(glm::max(glm::max(s.low() - h, h - s.high()), Vec3(0)));
    if (gap2 >= near2) continue;
    // Inside of a body it is not clear, however far the surface is: the next tick may have to put the IHIP out.
    if (gap2 == 0 && s.closed() && !body.pendingRemoval && windingNumber(s, h, allowance) > 0) near2 = 0;
    near2 = withinNearest2(s, h, near2, least2, allowance);
    if (near2 < least2 || allowance.isSpent()) break;
  }
  if (near2 < least2 || allowance.isSpent()) {
    clear.lastPause =
        std::clamp<std::uint16_t>(static_cast<std::uint16_t>(2 * clear.lastPause), kFirstPause, kLongestPause);
    clear.pause = clear.lastPause;
    return;
  }
  clear.lastPause = 0;
  clear.centre = state.hip;
  clear.radius_m = std::sqrt(near2) * kSure;
}

}  // namespace haptics
