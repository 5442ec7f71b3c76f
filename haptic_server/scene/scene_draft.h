#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "common/importer/mesh_recipe.h"
#include "common/scene/scene.h"
#include "haptic_server/scene/asset_resolver.h"
#include "haptic_server/scene/object_assets.h"
#include "haptic_server/scene/scene_limits.h"

namespace haptics {

struct MeshNumbers;
struct Price;

/// The next revision while its operations are tried on it one by one. The version it starts from stays as it is, so
/// that a rejected transaction is dropped by forgetting its draft.
class SceneDraft {
 public:
  using Assets = std::map<ObjectId, ObjectAssets>;

  /// `base` and its objects' assets outlive the draft. New objects are numbered from nextId.
  SceneDraft(const SceneVersion& base, const Assets& baseAssets, ObjectId nextId, const SceneLimits& limits = {});

  /// Errors name the field below the operation ("add.name"). Assets are made by resolve() only.
  [[nodiscard]] Result<void> apply(const Operation& operation, const std::string& field);
  /// Makes the assets that the operations named, after all of them are known to be right, and sees that those of each
  /// object fit together. Errors name the whole field.
  /// @return What making each kept and dropped.
  [[nodiscard]] Result<std::vector<std::string>> resolve(AssetResolver& resolver);
  /// What that takes at most, which it is refused by; imports of files, which have limits of their own, aside.
  [[nodiscard]] Price priceOf(AssetResolver& resolver) const;

  [[nodiscard]] Commit commit() const;  ///< Without its root.
  /// Objects that the operations have changed.
  [[nodiscard]] const std::vector<ObjectRecord>& objects() const noexcept { return changed_; }
  /// Assets of the objects that the operations gave a mesh or surface properties.
  [[nodiscard]] const Assets& assets() const noexcept { return assets_; }
  /// Objects whose pose the operations set, also to what it was.
  [[nodiscard]] const std::set<ObjectId>& posed() const noexcept { return posed_; }
  /// Objects whose mesh, lattice or residue they set, likewise.
  [[nodiscard]] const std::set<ObjectId>& reshaped() const noexcept { return reshaped_; }
  [[nodiscard]] ObjectId nextId() const noexcept { return nextId_; }

 private:
  enum class Place { kMesh, kFriction, kDynamicFriction, kTexture, kStiffness, kSoftness, kResidue };
  /// An asset to be made, and where its name goes.
  struct PendingAsset {
    std::string field;
    ObjectId object;
    std::string name;
    Place place;
    std::variant<const MeshSource*, const MappedSource*, const GrownSource*, const VertexValuesSource*,
                 const ResidueSource*>
        source;
  };
  /// The fields, if any, by which the operations last gave what an object is made of.
  struct FieldPaths {
    std::string mesh;         // "operations[0].remesh.mesh"
    std::string motion;       // "operations[0].add.motion."
    std::string deformation;  // "operations[0].add.deformation."
    std::string residue;      // "operations[0].set_deformation.deformation.residue"
    bool latticeOfMesh = false;
    std::map<std::string, std::string> surface;  // "texture": "operations[1].set_material.material."

    [[nodiscard]] bool onlyResidue() const {
      return mesh.empty() && motion.empty() && deformation.empty() && surface.empty();
    }
  };

  const SceneVersion& base_;
  const Assets& baseAssets_;
  ObjectId nextId_;
  SceneLimits limits_;
  std::size_t operations_ = 0;
  std::vector<ObjectRecord> changed_;  // in the order in which operations first named them
  std::set<ObjectId> removed_;         // of base_
  std::set<ObjectId> posed_, reshaped_;
  std::set<ObjectId> stiffened_;                  // whose stiffness or damping, or effects, were edited
  std::map<ObjectId, std::string> effectsGiven_;  // "operations[0].set_effects.effects": where they were, the last time
  std::vector<PendingAsset> pendingAssets_;
  std::map<ObjectId, FieldPaths> fieldPaths_;
  std::map<ContentHash, std::shared_ptr<const Asset>> made_;
  Assets assets_;

  /// A mesh that is here, or the recipe of one; neither: of a file that has not been read.
  struct PricedMesh {
    std::shared_ptr<const MeshAsset> asset;
    std::optional<MeshRecipe> recipe;
  };

  Result<void> apply(const AddObject& add, const std::string& field);
  Result<void> apply(const RemoveObject& remove, const std::string& field);
  Result<void> apply(const RemeshObject& remesh, const std::string& field);
  Result<void> apply(const SetPose& set, const std::string& field);
  Result<void> apply(const SetMaterial& set, const std::string& field);
  Result<void> apply(const SetMotion& set, const std::string& field);
  Result<void> apply(const SetDeformation& set, const std::string& field);
  Result<void> apply(const SetEffects& set, const std::string& field);
  /// Refused: more than a scene has.
  Result<void> setEffects(const std::vector<Effect>& effects, const std::string& field, ObjectRecord& record);
  void apply(const DeformationEdit& edit, const std::string& field, ObjectRecord& record);
  void apply(const SurfaceEdit& edit, const std::string& field, const ObjectRecord& record);
  /// Before anything is made, and again once all meshes are there: files then have told how much they hold.
  [[nodiscard]] Result<void> checkPrice(AssetResolver& resolver) const;
  [[nodiscard]] PricedMesh pricedMesh(const PendingAsset& named, AssetResolver& resolver) const;
  [[nodiscard]] static MeshNumbers numbersOf(const PricedMesh& mesh);
  [[nodiscard]] static double areaOf_m2(const PricedMesh& mesh);
  [[nodiscard]] Price priceOfMesh(const PendingAsset& named, const PricedMesh& mesh) const;
  [[nodiscard]] static Price priceOfField(const PendingAsset& named, const PricedMesh& mesh);
  [[nodiscard]] static Price priceOfParts(const ObjectRecord& record, const FieldPaths& given, const PricedMesh& mesh);
  [[nodiscard]] Price priceOfSharpPoints(const std::map<ObjectId, PricedMesh>& meshes) const;
  [[nodiscard]] const ObjectRecord* changed(ObjectId id) const;
  Result<std::string> make(const PendingAsset& named, AssetResolver& resolver);
  std::shared_ptr<const MeshAsset> meshOf(const PendingAsset& named);
  Result<void> checkRoom(const Asset& more) const;
  Result<void> checkDetailSizes() const;
  void dropResidue(ObjectRecord& record);
  void setAssetHash(const PendingAsset& named, const ContentHash& hash);
  void fitMapping(const PendingAsset& named);
  FactorMap* factorMap(const PendingAsset& named);
  FieldFamily* fieldFamily(const PendingAsset& named);
  Result<void> checkEffects(const ObjectRecord& record, const MeshAsset& mesh, const std::string& remesh) const;
  Result<void> checkMotion(const ObjectRecord& record, const FieldPaths& given) const;
  std::vector<KnownObject> known(const ObjectRecord& record, const AssetResolver& resolver) const;
  Result<void> checkMovingCount(const std::string& field) const;
  Result<void> fitDeformation(ObjectRecord& record, const FieldPaths& given) const;
  Result<void> gather(const ObjectRecord& record, const FieldPaths& given, AssetResolver& resolver);
  std::shared_ptr<const Asset> findAsset(ObjectId object, const ContentHash& hash) const;
  [[nodiscard]] std::vector<std::string> overlaps() const;
  const ObjectRecord* find(const ObjectRef& ref) const;
  Result<ObjectRecord*> edit(const ObjectRef& ref, const std::string& field);
  ObjectRecord* put(ObjectId id);
  /// Calls visit(record) for each object that the draft has.
  void forEachRecord(const auto& visit) const {
    for (const ObjectRecord& record : changed_) visit(record);
    for (const auto& record : base_.objects()) {
      const bool stays = !removed_.contains(record->id) && !std::ranges::count(changed_, record->id, &ObjectRecord::id);
      if (stays) visit(*record);
    }
  }
  std::vector<std::string> names() const;
};

}  // namespace haptics
