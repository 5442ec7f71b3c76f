#pragma once

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/motion_properties.h"
#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// The body that a mesh with these properties is, without its support points. Refused, naming the field below Motion: a
/// mesh that is open, inside out or flat and no inertia given; an inertia that no body has.
/// \param closed  CollisionMesh::closed() of the mesh: that its sides cancel is known then.
[[nodiscard]] Result<RigidBody> rigidBodyFrom(const MotionProperties& properties, const TriMesh& mesh,
                                              bool closed = false);

}  // namespace haptics
