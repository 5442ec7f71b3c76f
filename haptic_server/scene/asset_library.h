#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "haptic_server/scene/effect_limits.h"
#include "haptic_server/scene/field_library.h"
#include "haptic_server/scene/fit_to_mesh.h"
#include "haptic_server/scene/mesh_library.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {

/// Everything that an edit may name, from files, makers and the store. Any number of threads.
class AssetLibrary final : public AssetResolver {
 public:
  /// The store outlives the library. \param device for warnings.
  AssetLibrary(std::vector<std::filesystem::path> folders, AssetStore& store, const DeviceLimits& device = {})
      : folders_(std::move(folders)), device_(device), meshes_(folders_, store), fields_(folders_, store) {}

  [[nodiscard]] Result<Resolved<MeshAsset>> resolve(const MeshSource& source, double stiffness_N_per_m) override {
    return meshes_.resolve(source, stiffness_N_per_m);
  }
  [[nodiscard]] Result<Resolved<FieldAsset>> resolve(const FieldSource& source) override {
    return fields_.resolve(source);
  }
  [[nodiscard]] Result<Resolved<PointFieldAsset>> resolve(const PointFieldSource& source,
                                                          const MeshAsset& mesh) override {
    return fields_.resolve(source, mesh);
  }
  [[nodiscard]] Result<Resolved<VertexValuesAsset>> resolve(const VertexValuesSource& source) override {
    return fields_.resolve(source);
  }
  [[nodiscard]] Result<Resolved<MovedVerticesAsset>> resolve(const ResidueSource& source) override {
    return fields_.resolve(source);
  }
  [[nodiscard]] std::vector<std::string> warnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                  const EffectZones& effects) const override {
    auto warnings = surfaceWarnings(record, assets, device_);
    for (std::string& warning : motionWarnings(record, assets, device_)) warnings.push_back(std::move(warning));
    for (std::string& warning : effectWarnings(record, assets, effects, device_))
      warnings.push_back(std::move(warning));
    for (std::string& warning : deformationWarnings(record.deformation, *assets.mesh->mesh, assets.derived.flattened)) {
      warnings.push_back(std::move(warning));
    }
    return warnings;
  }

 private:
  const AssetFolders folders_;
  const DeviceLimits device_;
  MeshLibrary meshes_;
  FieldLibrary fields_;
};

}  // namespace haptics
