#pragma once

#include <memory>

#include "common/scene/surface_properties.h"
#include "common/surface/sampled_field.h"
#include "common/surface/scalar_field.h"

namespace haptics {

// Two-stage mapping (Bier & Sloan 1986; section 4.3.3 of the paper). Stage S lays square tiles of the plane field on the
// intermediate surface; stage O takes them from there to the object along the intermediate surface's normal. For a
// cylinder and a sphere that is the ray from the axis or the centre. Both stages together are one function of the place,
// so that the gradient follows by the chain rule; it has no part along the intermediate surface's normal (but where the
// blends below have one).
//
// The middle of a tile lies at the plane's and each face's middle, and for a cylinder and a sphere at (x, 0, 0).
//   Plane     x and y; seamless as the field is periodic.
//   Cube      any box: x and y along each face, upright with z and not mirrored as seen from outside. Faces are told
//             apart by the largest of |x| / half a side, ...; near the edges (from 4/5 of the way, C2) the faces' values
//             are blended, which costs contrast there: half way, two unrelated patterns keep 71 %.
//   Cylinder  turn and height. The turn holds a whole number of tiles: seamless.
//   Sphere    longitude and latitude; as on the cylinder along the equator.
// A turn shrinks to nothing at the axis: within a quarter of the radius of it the field goes over to its mean (C2), which
// it has within an eighth. So the field is flat at a sphere's poles and in the middle of a cylinder's ends, and likewise
// in the middle of a box.
//
// Bounds of slope and curvature: on the intermediate surface, by the samples of SplineBounds; nearer to the axis the
// slope grows as 1 / distance.

[[nodiscard]] std::shared_ptr<const ScalarField> makeMappedField(std::shared_ptr<const SampledField> field,
                                                                 const Mapping& mapping);

}  // namespace haptics
