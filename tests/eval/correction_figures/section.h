#pragma once

#include <span>
#include <vector>

#include "tests/eval/correction_figures/side_by_side.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// The plane of a section, in the frame of the scene's first body.
enum class Cut {
  kUpright,      ///< Along z and along the HIP's motion.
  kAcross,       ///< Along z and x.
  kFromAbove,    ///< Across z.
  kRadial,       ///< Along the way from the body's origin to the IHIP, and along the HIP's motion.
  kThroughBoth,  ///< Through the HIP and the IHIP of either method.
};

/// The moment that a figure shows.
struct Moment {
  Trace trace;  ///< The ticks to draw.
  std::size_t event = 0;
  std::vector<Vec3> slow;  ///< The IHIP of a slow hand on the same way; body frame, metres. May be empty.
};

/// For drawFigure("correction"): a section through the bodies at the moment, with HIP and IHIP of the ticks about it.
/// @param offset_m  Of the plane, from the IHIP of ours, along its normal.
[[nodiscard]] Record describeSection(const Moment& moment, Cut cut, double offset_m);

/// Likewise: the faces of a mesh that look along -z, and places on them.
[[nodiscard]] Record describePlaces(const CollisionMesh& surface, std::span<const Vec3> without,
                                    std::span<const Vec3> with);

/// How deep a place is inside of the bodies of a tick, m; 0 outside.
[[nodiscard]] double depthInside(const Trace& trace, const TracedTick& tick, Vec3 world);

}  // namespace haptics::eval
