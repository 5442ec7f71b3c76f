#pragma once

#include <span>

#include "common/deform/dent.h"
#include "haptic_server/engine/surface/shading_normals.h"

namespace haptics {

/// The surface as force shading sees it from some point h (object frame, metres).
struct ShadedPoint {
  /// From 0, where the unshaded vector is to be used, to 1.
  double weight = 0;
  std::uint32_t triangle = kNoTriangle;  ///< In which the point is.
  Vec3 normal{0};                        ///< N_s: unit, out of the polygons' outer side.
  double depth_m = 0;                    ///< From h along N_s to the polygon; negative beyond its outer side.
  double bulge_m = 0;                    ///< From there on to the smooth surface.
};

/// Eq. (1): the corners' normals weighted by the areas of the subtriangles opposite to them, given as parts of the
/// whole. On a line it is the paper's rule for lines, weights by the inverse of the distances, on a vertex that for
/// vertices. Not of unit length.
[[nodiscard]] inline Vec3 interpolatedNormal(const ShadingRecord& r, Vec3 parts) noexcept {
  return r.normal(0) * parts[0] + r.normal(1) * parts[1] + r.normal(2) * parts[2];
}

/// Force shading (paper 4.1): the direction N_s by Eq. (1), and h projected on to the surface along it.
///
/// @param foot  The point of the surface that is closest to h, with the primitive that holds it.
/// @param depth_m  Distance of foot and h, negative when h is beyond the outer side.
///
/// Deviations:
///  - N_s is that of the point where the projection arrives, not that of the IHIP: where h lies on the line along N_s
///    (Kobbelt et al. 1998, "Phong projection"). On a convex mesh the IHIP jumps from polygon to polygon, and the
///    paper's N_s jumps with it; this point moves over all lines without a jump. Found by Newton's method, polygon by
///    polygon from the IHIP's.
///  - The depth goes on to the quadratic surface that has these normals at these vertices (Boubekeur & Alexa, "Phong
///    Tessellation", 2008, with the factor 1/2 that is exact for quadratics). Up to the polygon only, the force's
///    magnitude would show the polygons though its direction does not, and direction and magnitude would belong to
///    different surfaces, which gives energy to the hand. The bulge is a height like a texture's: there is contact on
///    it outside of the polygons.
///  - "Works well when the penetration is small compared to the size of the polygon": where p tan(angle) comes near the
///    edge's length, that is where depth times curvature comes near 1, the weight goes smoothly to 0.
///  - Sharp lines and vertices have no normal of their own: weight 0.
[[nodiscard]] ShadedPoint shade(const CollisionMesh& surface, const ShadingNormals& normals, const ClosestPoint& foot,
                                Vec3 h, double depth_m) noexcept;

/// The same for a body with these dents: its triangles and normals are the dented ones; the foot is on them.
/// @param parts  May be null; else, where the weight is not 0, becomes what each corner of the triangle has of the point.
[[nodiscard]] ShadedPoint shade(const CollisionMesh& surface, const ShadingNormals& normals,
                                std::span<const Dent> dents, const Falloff& falloff, const ClosestPoint& foot,
                                const Vec3& h, double depth_m, Vec3* parts = nullptr) noexcept;

}  // namespace haptics
