#pragma once

#include <cstdint>

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/closest_point.h"
#include "haptic_server/engine/geometry/segment.h"

namespace haptics {

/// The corrections of the paper's pseudocode (README.md, section 2). The product has all of them on; the evaluation
/// switches one off at a time. followGuarded() alone reads them.
struct Corrections {
  /// Off: the closest primitive stays the polygon that the search starts from, which holds its own lines and vertices,
  /// so that none of its neighbours is strictly closer: the printed loop.
  bool featureCodes = true;
  /// Off: the sign at lines and vertices is that of the polygon the search ended in.
  bool pseudonormals = true;
  /// Off: the tick that first touches only records what it touched; the force comes with the next.
  bool sameTickSearch = true;
  /// Off: an IHIP that leaves a surface is free at once.
  bool exitRetest = true;
  /// Off: the world's segment in the frame that a moving body has at the end of the tick.
  bool objectFrameSegments = true;
  /// Off: the path on a surface is not tested, neither against other bodies nor against folds.
  bool guard = true;
  /// Off: one surface only. A blocked IHIP stays where it was blocked; a boundary is judged by its polygon.
  bool severalSurfaces = true;
  /// Off: a search ends at a local minimum only, however many triangles that takes.
  bool boundedSearch = true;
  /// Off: contact margin and offsets are the lengths that a scene of 0.1 m has.
  bool scaleFreeTolerances = true;
  /// Off: an IHIP that is inside a body is not noticed.
  bool containment = true;
  /// Off: the HIP's motion in a tick is one step.
  bool substeps = true;
  /// Off: steps by length, not from region to region; for another closest point computation, whose regions do not agree
  /// to the last bit.
  bool regionSteps = true;

  /// A segment against a triangle, as Segment::enters(); null: that one, which is watertight.
  using SegmentTest = bool (*)(Vec3 from, Vec3 to, const TriangleRecord&, bool twoSided, Crossing&) noexcept;
  SegmentTest segmentTest = nullptr;
  /// The closest point computation of the search (body frame, metres); null: closestOn().
  using ClosestPointFunction = ClosestPoint (*)(const TriangleRecord&, std::uint32_t triangle, Vec3 h) noexcept;
  ClosestPointFunction closestPoint = nullptr;

  /// Is some correction of the search itself off?
  [[nodiscard]] bool ablateSearch() const noexcept {
    return !featureCodes || !boundedSearch || closestPoint != nullptr;
  }
};

inline constexpr Corrections kAllCorrections;

}  // namespace haptics
