#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/deform/dent.h"
#include "common/scene/deformation_properties.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {

/// A dent that the servo has left to stay, by its number.
struct PermanentDent {
  std::uint64_t number = 0;
  Dent dent;
};

/// Up to which number each object's dents were handled, whether the servo has followed or not yet.
struct DentWatermark {
  std::uint64_t upTo = 0;          ///< Baked.
  std::uint64_t releasedUpTo = 0;  ///< Or not allowed to stay.
};
using DentWatermarks = std::map<std::uint64_t, DentWatermark>;

/// By object, those that are to be baked, in the order in which they come one after another: those that stay, before the
/// first that does not.
[[nodiscard]] std::map<std::uint64_t, std::vector<PermanentDent>> permanentDents(const MotionState& motion,
                                                                                 const DentWatermarks& handled);

/// Result of baking an object's permanent dents.
struct BakeResult {
  std::uint64_t upTo = 0;  ///< The residue holds the dents up to this number; 0: none.
  /// Then all vertices that are elsewhere now, those of before included; none where dents lie between vertices.
  MovedVertices residue;
  std::uint64_t releasedUpTo = 0;  ///< The next one up to this number may not stay; 0: none.
};

/// Bakes dents into the shape at rest, one after the other, up to the first one that would displace the vertices too far
/// from where mesh and lattice have them, or beyond where MovedVertices can have them: the difference of the displacements of two neighbours stays within kMaxDentGradient
/// of their distance, whatever is pressed how often, so that no triangle turns over unless one of its angles is larger than
/// 120 degrees.
/// @param assets  Of the object that has these properties.
[[nodiscard]] BakeResult bake(const DeformationProperties& properties, const ObjectAssets& assets,
                              std::span<const PermanentDent> dents);

}  // namespace haptics
