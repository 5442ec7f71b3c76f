#pragma once

#include <cstdint>

#include "common/maths/vec.h"
#include "haptic_server/geometry/closest_point.h"
#include "haptic_server/geometry/segment.h"

namespace haptics {

/// What the contact core does beyond the paper's pseudocode, as a compile-time policy. Production has all of it, and is
/// compiled for nothing else; the evaluation derives policies with one correction switched off (contact_tick_impl.h),
/// to show what it is for.
struct AllCorrections {
  /// Off: the closest primitive stays the polygon that the search starts from, which holds its own lines and vertices,
  /// so that none of its neighbours is strictly closer: the printed loop.
  static constexpr bool kFeatureCodes = true;
  /// Off: the sign at lines and vertices is that of the polygon the search ended in.
  static constexpr bool kPseudonormals = true;
  /// Off: the tick that first touches only records what it touched; the force comes with the next.
  static constexpr bool kSameTickSearch = true;
  /// Off: an IHIP that leaves a surface is free at once.
  static constexpr bool kExitRetest = true;
  /// Off: the world's segment in the frame that a moving body has at the end of the tick.
  static constexpr bool kObjectFrameSegments = true;
  /// Off: the path on a surface is tested against nothing, neither other bodies nor folds.
  static constexpr bool kGuard = true;
  /// Off: one surface only. A blocked IHIP stays where it was blocked; a boundary is judged by its polygon.
  static constexpr bool kSeveralSurfaces = true;
  /// Off: a search ends where there is nothing closer, however far.
  static constexpr bool kBoundedSearch = true;
  /// Off: skin and lift are lengths, those that a scene of 0.1 m has.
  static constexpr bool kScaleFreeTolerances = true;
  /// Off: an IHIP that is inside a body is not noticed.
  static constexpr bool kContainment = true;
  /// Off: the HIP's motion in a tick is one step.
  static constexpr bool kSubsteps = true;

  /// A segment against a triangle: watertight. Another one has the same constructor and enters().
  using SegmentTest = Segment;

  /// Off: steps of a length, not from primitive to primitive; for another closest point computation, which does not
  /// agree to the last bit on where their regions meet.
  static constexpr bool kRegionSteps = true;
  /// The closest point computation of the search; body frame, metres.
  [[nodiscard]] static Foot closestPoint(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
    return closestOn(record, triangle, h);
  }
};

}  // namespace haptics
