#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {

class EffectZones;

template <class Kind>
struct Resolved {
  std::shared_ptr<const Kind> asset;
  std::string report;  ///< Of its import or generation, one line.
};

/// An object that an edit was going to make, with all that was made of it.
struct PreparedObject {
  ObjectRecord record;
  ObjectAssets assets;
};

/// Makes the assets that an edit names. The sequencer sees only this, so that a simulation needs no files.
class AssetResolver {
 public:
  virtual ~AssetResolver() = default;
  /// Called before work on so many triangles of a mesh, which is not done where this is refused.
  [[nodiscard]] virtual Result<void> beforeWork([[maybe_unused]] std::size_t triangles) { return {}; }
  /// Whether something was refused because it takes long, and is to be prepared first.
  [[nodiscard]] virtual bool needsPreparation() const { return false; }
  /// The object of this name, where the edit was tried before; null: it was not, or holds no such object.
  [[nodiscard]] virtual const PreparedObject* prepared([[maybe_unused]] const std::string& name) const {
    return nullptr;
  }
  /// Errors name the field below the MeshSource ("file", "torus.minor_radius_m"),
  /// @param stiffness_N_per_m  Of the object, with which a mesh that is to be simplified is judged.
  [[nodiscard]] virtual Result<Resolved<MeshAsset>> resolve(const MeshSource& source, double stiffness_N_per_m) = 0;
  /// below MappedField ("image"),
  [[nodiscard]] virtual Result<Resolved<FieldAsset>> resolve(const FieldSource& source) = 0;
  /// below GrownField ("reaction_diffusion.wavelength_m"),
  [[nodiscard]] virtual Result<Resolved<PointFieldAsset>> resolve(const PointFieldSource& source,
                                                                  const MeshAsset& mesh) = 0;
  /// and below PerVertex ("asset").
  [[nodiscard]] virtual Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source) = 0;
  /// Errors name the field below Residue ("asset").
  [[nodiscard]] virtual Result<Resolved<MovedVerticesAsset>> resolve(const ResidueSource& source) = 0;
  /// Warnings about an object as an edit would make it, a line each.
  /// @param effects  Of all objects of the scene.
  [[nodiscard]] virtual std::vector<std::string> warnings(const ObjectRecord& /*record*/,
                                                          const ObjectAssets& /*assets*/,
                                                          const EffectZones& /*effects*/) const {
    return {};
  }
};

}  // namespace haptics
