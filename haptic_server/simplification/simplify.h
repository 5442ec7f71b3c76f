#pragma once

#include <memory>
#include <optional>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// What is left of a mesh that keeps only what a hand can tell.
struct SimplifiedMesh {
  TriMesh mesh;                                  ///< Canonical order.
  std::shared_ptr<const CollisionMesh> surface;  ///< Of it.
  double error_jnd = 0;  ///< Of the force, not exceeded in 99 % of the ticks on the strokes it was judged by.
};

/// Of all strokes that simplify() tries, about.
[[nodiscard]] double placesOfStrokes(double longestSide_m, double stiffness_N_per_m) noexcept;
/// Refused: to press 1 N into it takes so long a way that the strokes have too many places, in all kMaxPlaces.
[[nodiscard]] Result<void> checkSimplifiable(const CollisionMesh& surface, double stiffness_N_per_m);
/// 100 MB and some 20 s. Larger lets softer and smaller meshes be simplified.
inline constexpr double kMaxPlaces = 2e6;

/// The fewest triangles found with which a mesh feels the same (common/maths/perception.h): of a series of copies by
/// Decimation, each of 0.7 times the triangles of the one before, fitted to the mesh and mended where they pass through
/// themselves, one that
///  - along 1,000 strokes all over the mesh (probeStrokes()) gives forces that differ by less than 0.75 of
///    `error_jnd` in 99 % of the ticks; the quarter is for strokes that are not tried;
///  - is nowhere farther from the mesh's vertices than twice what a press of 1 N tells, which is 7 % of 1 N over the
///    stiffness, times `error_jnd`, before it is mended by as much (repairSelfIntersections());
///  - has an inside if the mesh has.
/// None where every copy fails. A rigid body at rest, felt without shading, friction, texture and softness, is what is
/// judged. The same mesh, error and stiffness give the same result on every machine.
///
/// Works in two threads, some 5 s for 870,430 triangles, in which the calling one may be interrupted. Allocates.
/// @param error_jnd  > 0; 1 is just noticeable.
/// @param surface, stiffness_N_per_m  Of which checkSimplifiable() approves.
[[nodiscard]] std::optional<SimplifiedMesh> simplify(const TriMesh& mesh, const CollisionMesh& surface,
                                                     double error_jnd, double stiffness_N_per_m);

}  // namespace haptics
