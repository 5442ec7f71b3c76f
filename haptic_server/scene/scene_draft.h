#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/mesh_resolver.h"

namespace haptics {

/// The next revision while its operations are tried on it one by one. The version it starts from stays as it is, so
/// that a rejected transaction is dropped by forgetting its draft.
class SceneDraft {
 public:
  using Meshes = std::map<ObjectId, std::shared_ptr<const MeshAsset>>;

  /// `base` outlives the draft. New objects are numbered from nextId.
  SceneDraft(const SceneVersion& base, ObjectId nextId);

  /// Errors name the field below the operation ("add.name"). Meshes are made by resolveMeshes() only.
  [[nodiscard]] Result<void> apply(const Operation& operation, const std::string& field);
  /// Makes the meshes that the operations named, after all of them are known to be right. Errors name the whole field.
  /// @return What making each kept and dropped.
  [[nodiscard]] Result<std::vector<std::string>> resolveMeshes(MeshResolver& resolver);

  [[nodiscard]] Commit commit() const;                                     ///< Without its root.
  [[nodiscard]] const Meshes& meshes() const noexcept { return meshes_; }  ///< Of added and re-meshed objects.
  [[nodiscard]] ObjectId nextId() const noexcept { return nextId_; }

 private:
  struct NamedMesh {
    std::string field;
    ObjectId object;
    std::string name;
    const MeshSource* source;
  };

  const SceneVersion& base_;
  ObjectId nextId_;
  std::vector<ObjectRecord> put_;  // in the order in which operations first named them
  std::set<ObjectId> removed_;     // of base_
  std::vector<NamedMesh> named_;
  Meshes meshes_;

  Result<void> apply(const AddObject& add, const std::string& field);
  Result<void> apply(const RemoveObject& remove, const std::string& field);
  Result<void> apply(const RemeshObject& remesh, const std::string& field);
  Result<void> apply(const SetPose& set, const std::string& field);
  Result<void> apply(const SetMaterial& set, const std::string& field);
  const ObjectRecord* find(const ObjectRef& ref) const;
  Result<ObjectRecord*> edit(const ObjectRef& ref, const std::string& field);
  ObjectRecord* put(ObjectId id);
  std::vector<std::string> names() const;
};

}  // namespace haptics
