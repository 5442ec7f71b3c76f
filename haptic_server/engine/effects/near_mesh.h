#pragma once

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// What an effect takes from the mesh of the object that carries it, at the HIP; object frame.
struct NearMesh {
  bool isFound = false;  ///< Something lies nearer than was asked for; the HIP is inside.
  Vec3 point{0};         ///< The nearest place.
  Vec3 along{0};         ///< Of an edge: unit, 0 where it ends or others meet it, and continuous between.
  double depth_m = 0;    ///< Inside: the way to the surface, as far as was asked for.
};

// The answer of a query that has spent the allowance means nothing.

/// @param within_m  Only what is nearer than this.
[[nodiscard]] NearMesh nearestPlace(const CollisionMesh& mesh, Vec3 hip, double within_m,
                                    Allowance& allowance) noexcept;
[[nodiscard]] NearMesh nearestVertex(const CollisionMesh& mesh, Vec3 hip, double within_m,
                                     Allowance& allowance) noexcept;
/// Of those at which the mesh bends by 30 degrees or more, or ends.
[[nodiscard]] NearMesh nearestEdge(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept;
/// By the winding number, of a closed mesh.
[[nodiscard]] NearMesh inside(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept;

}  // namespace haptics
