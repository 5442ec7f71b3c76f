#pragma once

#include <optional>
#include <vector>

#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// How far a view's IHIP is from the surface of what it touches, both as the view has them: the surface where pose, lattice
/// and dents put it, every triangle of it that could be the nearest. What a viewer shows of a contact is true to within this.
class ContactError {
 public:
  /// Metres, not negative; a texture's height is taken off. Nothing where no object that moves or gives is touched, or its
  /// mesh is not here.
  /// @param sample  Of one of the view's hands.
  [[nodiscard]] std::optional<double> of_m(const MirrorView& view, const TelemetrySample& sample);

 private:
  SceneVersion::Object object_;        // that shaped_ is of,
  DeformationProperties deformation_;  // as this has it
  std::vector<Vec3f> shaped_;

  const std::vector<Vec3f>& atRest(const SceneVersion::Object& object, const TriMesh& mesh,
                                   const DeformationProperties& deformation, const MovedVertices* residue);
};

}  // namespace haptics
