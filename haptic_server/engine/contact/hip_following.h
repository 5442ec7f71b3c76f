#pragma once

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/neighborhood_watch.h"

namespace haptics {

/// Steps into which the HIP's motion is divided, at most.
inline constexpr int kMaxSteps = 64;
/// How far, as a fraction of the tick, beyond the region of the primitive that the HIP has left the next search is
/// made. Larger confuses the order in which primitives are left, and where a minimum ends leads to another one than a
/// slow hand's: at 2^-6 twice as often on a scan of 870,000 triangles. Smaller drowns in rounding where the HIP is
/// slow.
inline constexpr double kMinStep = 0x1p-12;
/// The same once a tick has taken half of its steps, so that the others reach its end.
inline constexpr double kLongStep = 2.0 / kMaxSteps;

/// A primitive whose region the HIP has left, and that is found again some time later, is left along its boundary, by rounding
/// alone. The next step is so many times as long as that.
inline constexpr double kAlongBoundary = 7;

/// The HIP's path in a tick, in the frame of the body that holds the IHIP, metres.
struct HipMotion {
  Vec3 from;
  Vec3 to;

  [[nodiscard]] Vec3 at(double time) const noexcept { return time < 1 ? glm::mix(from, to, time) : to; }
};

/// A step along the HIP's path.
struct HipStep {
  double end;          ///< Time, as a fraction of the tick.
  SearchResult found;  ///< At that time.
};

/// The foot on the one surface that holds the IHIP, of h, the HIP of the last tick (body frame). On a polygon only the
/// triangle is set.
[[nodiscard]] inline ClosestPoint heldFoot(const CollisionMesh& surface, const ContactState& state, Vec3 h) noexcept {
  const std::uint32_t triangle = state.holding[0].triangle;
  return state.feature == Feature::kPolygon ? ClosestPoint{triangle}
                                            : closestOn(surface.triangle(triangle), triangle, h);
}

/// Follows the HIP from polygon to polygon, as long as it goes from one's prism into the next one's, straight or by the
/// wedge over the line between. Returns whether that leads to the end of the motion.
/// @param[in,out] foot, now  Of the last polygon that was entered.
[[nodiscard]] bool followOverPolygons(const CollisionMesh& surface, const HipMotion& motion, int side,
                                      ClosestPoint& foot, double& now, SearchRun& run) noexcept;

/// The time at which the HIP leaves the region for which the line or vertex of the foot is a local
/// minimum of the distance: over a line the wedge between the prisms beside it, over a vertex the cone between the
/// planes at the ends of its lines. 1 when it stays; `now` where that is not known.
[[nodiscard]] double timeInRegion(const CollisionMesh& surface, const ClosestPoint& foot, const HipMotion& motion,
                                  double now) noexcept;

/// To where the HIP leaves the region of the primitive that holds the foot. As long as it stays there nothing can
/// change but the place on the primitive, so that steps go from region to region, and none, however long, takes the
/// IHIP along another path than a slow hand's. Returns the time of the next search, a little later.
/// @param number  Of the step in its tick, from 1.
/// @param[in,out] found  The foot at time `now`; then that from whose triangle to search, or, `converged`, the local
///              minimum at the end of the motion.
[[nodiscard]] double leaveRegion(const CollisionMesh& surface, const HipMotion& motion, int side, double now,
                                 int number, SearchResult& found, SearchRun& run) noexcept;

/// A step of the IHIP over a surface: leaveRegion(), and the search there.
[[nodiscard]] HipStep followHip(const CollisionMesh& surface, const HipMotion& motion, int side,
                                const ClosestPoint& foot, double now, int number, SearchRun& run) noexcept;

}  // namespace haptics
