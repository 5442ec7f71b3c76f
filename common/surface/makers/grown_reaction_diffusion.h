#pragma once

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/surface_edits.h"
#include "common/surface/point_field.h"

namespace haptics {

/// Spots or stripes that grow on the mesh itself (Turk 1991): no seam, and nothing stretched, whatever its shape. The
/// equations are those of reactionDiffusion(). They are solved on samples of the mesh, evenly spaced at a seventh of the
/// wavelength; each exchanges with those within two spacings that are on its side, so that the two sides of a thin sheet
/// do not mix. Where the surface ends nothing flows over its edge. The concentration of the first substance, mean 0,
/// scaled to reach 1 or -1. The same samples on every machine (basic operations alone).
///
/// Deviations from Turk: samples are made even by elimination instead of relaxation; distances are straight, not along
/// the surface; what two samples exchange depends on their distance and not on the border of their Voronoi cells, and is
/// scaled as a whole so that waves of the wavelength asked for diffuse as on a plane.
///
/// Takes up to 100 us a sample. Refused, naming "reaction_diffusion.wavelength_m": a wavelength that takes
/// more samples than PointField::kMaxSamples, or so few that no pattern can form.
[[nodiscard]] Result<PointField> grownReactionDiffusion(const TriMesh& mesh,
                                                        const GrownReactionDiffusionSource& source);
/// How many samples that takes of a surface of this area.
[[nodiscard]] double samplesToGrow(const GrownReactionDiffusionSource& source, double area_m2) noexcept;

}  // namespace haptics
