#pragma once

#include <optional>
#include <span>

#include "haptic_server/engine/contact/constraints.h"
#include "haptic_server/engine/contact/tick_context.h"

// What the files of the plane solver share.

namespace haptics {

/// Follows the surfaces that hold from triangle to triangle, without meeting them again.
[[nodiscard]] SolverStep followActiveSet(TickContext& tick, Vec3 hip) noexcept;
/// The neighborhood watch from a surface that the IHIP touches.
enum class Watch {
  kNone,     ///< It means nothing there, or came to no end.
  kBlocked,  ///< Something is in its way.
  kEnded,    ///< `step` has the surface at its end.
};
[[nodiscard]] Watch continueWatch(TickContext& tick, Vec3 hip, SolverStep& step) noexcept;

/// Straight to a place in the world, unless something is in the way.
[[nodiscard]] NearBodies::Hit tryMoveTo(TickContext& tick, Vec3 world) noexcept;
/// The plane of a triangle, offset outwards by a skin.
[[nodiscard]] ConstraintPlane planeOf(const TickContext& tick, const ContactSurface& s) noexcept;
/// Is the IHIP no farther than so many skins from a triangle?
[[nodiscard]] bool isWithin(const TickContext& tick, double skins, const ContactSurface& s) noexcept;
/// Do all that push belong to one surface? So do the triangles around one vertex.
[[nodiscard]] bool isOneSurface(const TickContext& tick, const SolverStep& step) noexcept;

/// One triangle of each surface that holds: of each body, and of each part of one that crosses itself.
[[nodiscard]] ActiveSet heldSurfaces(const TickContext& tick) noexcept;
/// The neighbour of a surface over edge k of its triangle.
[[nodiscard]] std::optional<ContactSurface> across(const TickContext& tick, const ContactSurface& s, int k) noexcept;
/// How far on the straight move to the optimum the triangles stay under the IHIP.
[[nodiscard]] SupportLimit supportLimit(const TickContext& tick, std::span<const ContactSurface> surfaces,
                                        const Constraints& constraints) noexcept;

}  // namespace haptics
