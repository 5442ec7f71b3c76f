#pragma once

#include <memory>
#include <string>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "haptic_server/scene/asset_store.h"

namespace haptics {

struct ResolvedMesh {
  std::shared_ptr<const MeshAsset> asset;
  std::string report;  ///< What importing or generating it kept and dropped, one line.
};

/// Makes the mesh that an edit names. The sequencer sees only this, so that a simulation needs no files.
class MeshResolver {
 public:
  virtual ~MeshResolver() = default;
  /// Errors name the field below the MeshSource ("file", "torus.minor_radius_m").
  [[nodiscard]] virtual Result<ResolvedMesh> resolve(const MeshSource& source) = 0;
};

}  // namespace haptics
