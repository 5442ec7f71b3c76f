#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/simplification/force_difference.h"

namespace haptics {

/// Places of the HIP, one to a tick; object frame, m.
using ProbeStroke = std::vector<Vec3>;

/// The contact's spring along each stroke, N: by the contact core alone, on the surface alone, at rest.
[[nodiscard]] std::vector<Forces> forcesAlong(const std::vector<ProbeStroke>& strokes, const CollisionMesh& surface,
                                              double stiffness_N_per_m);

struct Probes {
  std::vector<ProbeStroke> strokes;
  std::vector<Forces> forces;  ///< On the mesh itself.
};

/// About how many places a stroke has: more the softer and the smaller the mesh is. What it costs, 48 bytes and one contact
/// for each and each copy that is judged.
[[nodiscard]] double placesOfAStroke(double longestSide_m, double stiffness_N_per_m) noexcept;

/// Strokes over all of a mesh, as many to an area wherever it is, but none from within it: down onto a triangle, as deep as
/// 1 N presses there, straight on for an eighth of the longest side or 20 mm, and up again. Straight, so that they cross
/// edges, leave the surface and enter it again; each ends where it takes 2 N, since a hand that presses with 1 N gives way
/// there. At most 0.1 mm from place to place: 0.1 m/s at 1 kHz.
/// @param seed  Other seeds give other places and directions; the same one the same strokes, bit for bit.
[[nodiscard]] Probes probeStrokes(const TriMesh& mesh, const CollisionMesh& surface, double stiffness_N_per_m,
                                  std::size_t count, std::uint64_t seed);

}  // namespace haptics
