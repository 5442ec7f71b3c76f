#pragma once

#include "haptic_server/engine/contact/hip_following.h"
#include "haptic_server/engine/contact/tick_context.h"

namespace haptics {

/// A step of the tick. The path of the IHIP is kept where it has to be guarded.
struct WalkStep {
  double end;  ///< Time, as a fraction of the tick.
  Vec3 hip;    ///< The HIP then, world;
  Vec3 h;      ///< in the frame of the body that holds the IHIP.
  /// After a search its result; before, the foot that it starts from, `converged` where that is a local minimum
  /// already.
  SearchResult found;
  int budget;  ///< Of the search (searchBudget()).
  bool guarded;
  SearchPath path;

  [[nodiscard]] SearchPath* guardedPath() noexcept { return guarded ? &path : nullptr; }
};

/// The HIP's path in the tick in the frame of the body that holds the IHIP.
[[nodiscard]] HipMotion hipMotion(const TickContext& tick) noexcept;
/// The time to advance to from `now` where the HIP is followed by length.
[[nodiscard]] double shortStepEnd(const TickContext& tick, double now) noexcept;

/// Begins a step at time `now`: to where the HIP leaves the region of the contacted primitive. `last`: to the end of
/// the tick.
void stepOverRegions(TickContext& tick, double now, bool last, WalkStep& step) noexcept;
/// Begins a step in which no time passes: the IHIP has gone with the deforming surface that holds it, and is to come to the
/// place on it that is nearest to the HIP.
void settle(TickContext& tick, WalkStep& step) noexcept;
/// Begins another search for the HIP at the end of the step, from the surface that was entered within it.
void searchAnew(const TickContext& tick, WalkStep& step) noexcept;

/// The neighborhood watch for h (body frame, metres) from the triangle of a surface. `path` may be null.
[[nodiscard]] SearchResult search(TickContext& tick, const ContactSurface& from, Vec3 h, SearchPath* path) noexcept;
/// The same for a step.
void search(TickContext& tick, WalkStep& step) noexcept;
/// Moves the IHIP along the path of the search. False where the plane solver has to take over: at what blocks it, with
/// the IHIP at the last clear point, and at a boundary.
[[nodiscard]] bool followPath(TickContext& tick, WalkStep& step) noexcept;
/// Is the HIP outside of the surface? Not known before the search has converged.
[[nodiscard]] bool isOutside(TickContext& tick, const WalkStep& step) noexcept;

}  // namespace haptics
