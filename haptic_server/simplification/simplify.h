#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/geometry/collision_mesh.h"

namespace haptics {

/// What is left of a mesh that keeps only what a hand can tell.
struct SimplifiedMesh {
  TriMesh mesh;          ///< Canonical order.
  double error_jnd = 0;  ///< Of the force, not exceeded in 99 % of the ticks on the strokes it was judged by.
};

/// The fewest triangles found with which a mesh feels the same (common/maths/perception.h): of a series of copies by
/// Decimation, each of 0.7 times the triangles of the one before, fitted to the mesh and mended where they pass through
/// themselves, one that
///  - along 300 strokes all over the mesh (probeStrokes()) gives forces that differ by less than 0.9 of
///    `error_jnd` in 99 % of the ticks; the tenth is for strokes that are not tried;
///  - is nowhere farther from 60,000 of the mesh's vertices than twice what a press of 1 N tells, which is 7 % of 1 N over
///    the stiffness, times `error_jnd`;
///  - has an inside if the mesh has.
/// None where every copy fails. A rigid body at rest, felt without shading, friction, texture and softness, is what is
/// judged. The same mesh, error and stiffness give the same result on every machine.
///
/// Takes 7.6 s of processor time for 870,430 triangles, in which the thread may be interrupted. Allocates.
/// @param error_jnd  > 0; 1 is just noticeable.
[[nodiscard]] std::optional<SimplifiedMesh> simplify(const TriMesh& mesh, const CollisionMesh& surface,
                                                     double error_jnd, double stiffness_N_per_m);

}  // namespace haptics
