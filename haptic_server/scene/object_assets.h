#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "common/surface/scalar_field.h"
#include "haptic_server/scene/asset_store.h"
#include "haptic_server/scene/derived_parts.h"

namespace haptics {

/// The assets that an object's record names, with the fields made of them.
struct ObjectAssets {
  std::shared_ptr<const MeshAsset> mesh;
  std::vector<std::shared_ptr<const Asset>> others;        ///< All but the mesh.
  std::shared_ptr<const ScalarField> textureField;         ///< Null without a texture.
  std::shared_ptr<const ScalarField> frictionField;        ///< Null unless friction varies over a field.
  std::shared_ptr<const VertexValuesAsset> frictionScale;  ///< Null unless friction is given per vertex.
  /// The same of the dynamic coefficient's own map.
  std::shared_ptr<const ScalarField> dynamicFrictionField;
  std::shared_ptr<const VertexValuesAsset> dynamicFrictionScale;
  /// The same of what stiffness and softness follow.
  std::shared_ptr<const ScalarField> stiffnessField, softnessField;
  std::shared_ptr<const VertexValuesAsset> stiffnessScale, softnessScale;
  std::shared_ptr<const MovedVerticesAsset> residue;  ///< Null unless plastic dents have left one.
  DerivedParts derived;

  /// The mesh's vertices as lattice and residue have them, for an object with these assets.
  [[nodiscard]] std::vector<Vec3f> shapeAtRest(const DeformationProperties& deformation) const {
    return haptics::shapeAtRest(deformation, mesh->mesh->vertices, residue ? residue->moved.get() : nullptr);
  }
  /// The surface of that shape. One that the lattice mirrors has its faces turned over: they look outwards again.
  /// @param last  Of an earlier shape of this mesh, near which the new one is; null: there is none.
  [[nodiscard]] std::shared_ptr<const CollisionMesh> surfaceAtRest(const DeformationProperties& deformation,
                                                                   const CollisionMesh* last = nullptr) const;
  /// Whether these places of the mesh's vertices turn it, where it is closed, inside out from those.
  [[nodiscard]] bool turnsOver(std::span<const Vec3f> from, std::span<const Vec3f> to) const;
  [[nodiscard]] std::shared_ptr<const Asset> find(const ContentHash& hash) const;
};

using AssetLookup = std::function<Result<std::shared_ptr<const Asset>>(const AssetName&)>;

/// Everything that the record names. Refused: what the lookup refuses, an asset of another kind than its place asks for,
/// values or creases that do not fit the mesh; errors name the field below ObjectState ("friction.per_vertex").
/// \param creasesFit  That is known.
[[nodiscard]] Result<ObjectAssets> gatherAssets(const ObjectRecord& record, const AssetLookup& lookUp,
                                                bool creasesFit = false);

}  // namespace haptics
