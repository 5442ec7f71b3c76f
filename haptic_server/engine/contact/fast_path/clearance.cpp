#include "haptic_server/engine/contact/fast_path/clearance.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/geometry/enclosure.h"

namespace haptics {
namespace {

/// Steps of the HIP for which a clearance has to last, and beyond which it is not looked for. Fewer take too many
/// searches, more are seldom made in one direction.
constexpr double kMinSteps = 8;
constexpr double kMaxClearanceSteps = 512;
/// Least step of the HIP.
constexpr double kMinStep_m = 1e-5;
/// Ticks until the next search after one in vain: twice as many each time.
constexpr std::uint32_t kFirstPause = 8;
constexpr std::uint32_t kLongestPause = 256;
/// The part of a clearance that is certain: rounding may have added the rest.
constexpr double kSure = 1 - 0x1p-18;
/// Fraction of the squared distance that is found, at least: of the many triangles of a fine surface that are nearly
/// the nearest the search leaves most out.
constexpr double kShareFound = 0.25;

/// At most the squared distance from h (body frame) to the nearest triangle, and at least kShareFound of it; `bound`
/// where that is less; m^2. Not looked for any farther once it is below `least`.
[[nodiscard, gnu::flatten]] double withinNearest2(const CollisionMesh& surface, Vec3 h, double bound, double least,
                                                  Allowance& allowance) noexcept {
  double nearest = bound, leftOut = bound;
  surface.hierarchy().visitNear(
      h, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t) {
          nearest = std::min(nearest, closestOn(surface.triangle(t), t, h).squaredDistance);
        }
        return nearest < least ? -1.0 : std::min(bound, kShareFound * nearest);
      },
      bound, [&](double squared) noexcept { leftOut = std::min(leftOut, squared); });
  return std::min(nearest, leftOut);
}

}  // namespace

double largestMotion_m(const Body& body) noexcept {
  const Quat turn = body.current.rotation * glm::conjugate(body.previous.rotation);
  const double centre = glm::distance(toWorld(body.previous, body.surface->centre()), body.centre);
  return centre + 2 * body.surface->radius_m() * glm::length(Vec3(turn.x, turn.y, turn.z));
}

void lookForClearance(std::span<const Body> bodies, ContactState& state, const Vec3& before,
                      Allowance& allowance) noexcept {
  Clearance& clear = state.clear;
  if (clear.pause > 0) {
    --clear.pause;
    return;
  }
  const double step = std::max(glm::distance(before, state.hip), kMinStep_m);
  const double least2 = kMinSteps * step * (kMinSteps * step);
  double near2 = kMaxClearanceSteps * step * (kMaxClearanceSteps * step);
  for (const Body& body : bodies) {
    const Vec3 h = body.frame.toLocal(state.hip);
    const CollisionMesh& s = *body.surface;
    const double gap2 = squaredLength(glm::max(glm::max(s.low() - h, h - s.high()), Vec3(0)));
    if (gap2 >= near2) continue;
    // Inside of a body it is not clear, however far the surface is: the next tick may have to put the IHIP out.
    const bool mayBeInside = gap2 == 0 && s.closed() && !body.pendingRemoval && clear.radius_m == 0;
    if (mayBeInside && windingNumber(s, h, allowance) > 0) near2 = 0;
    near2 = withinNearest2(s, h, near2, least2, allowance);
    if (near2 < least2 || allowance.isSpent()) break;
  }
  if (near2 < least2 || allowance.isSpent()) {
    clear.lastPause = std::clamp(2 * clear.lastPause, kFirstPause, kLongestPause);
    clear.pause = clear.lastPause;
    return;
  }
  clear.lastPause = 0;
  clear.centre = state.hip;
  clear.radius_m = std::sqrt(near2) * kSure;
}

}  // namespace haptics
