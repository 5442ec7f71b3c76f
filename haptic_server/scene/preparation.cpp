#include "haptic_server/scene/preparation.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "common/interruption/interruption.h"
#include "haptic_server/scene/mesh_library.h"
#include "haptic_server/scene/scene_draft.h"

namespace haptics {

void Preparation::prepare(const Sequencer::Scene& scene, const Transaction& transaction) {
  mayTakeLong_ = true;
  needsPreparation_ = false;
  gone_ = 0;
  objects_.clear();
  SceneDraft draft(scene.history->version, scene.assets, scene.nextId, scene.limits);
  bool applies = true;
  for (const Operation& operation : transaction.operations) applies = applies && draft.apply(operation, "").has_value();
  if (applies) (void)draft.resolve(*this);  // what is wrong with it is said when it is decided
  for (const ObjectRecord& record : draft.objects()) {
    const auto assets = draft.assets().find(record.id);
    if (assets != draft.assets().end()) objects_.push_back({record, assets->second});
  }
  mayTakeLong_ = false;
}

tl::unexpected<Error> Preparation::refuseLongWork() {
  needsPreparation_ = true;
  return refused("", "takes long");
}

template <class Key, class Kind, class Make>
Result<Resolved<Kind>> Preparation::once(Kept<Key, Kind>& kept, Key place, Make make, double triangles) {
  if (const auto at = kept.find(place); at != kept.end()) return at->second;
  if (!mayGoThrough(triangles)) return refuseLongWork();
  auto made = make();
  interruptionPoint();  // what another process was making when it was cancelled counts as refused
  return kept.emplace(place, std::move(made)).first->second;
}

Result<Resolved<MeshAsset>> Preparation::resolve(const MeshSource& source, double stiffness_N_per_m) {
  const auto resolve = [&] { return library_.resolve(source, stiffness_N_per_m); };
  if (!source.simplifyError && std::holds_alternative<AssetSource>(source.source)) return resolve();
  // nothing goes by the stiffness where nothing is simplified
  return once(meshes_, MeshPlace{&source, source.simplifyError ? stiffness_N_per_m : 0}, resolve,
              source.simplifyError ? kMany : trianglesMadeFor(source));
}

Result<Resolved<FieldAsset>> Preparation::resolve(const FieldSource& source) {
  if (std::holds_alternative<AssetSource>(source)) return library_.resolve(source);
  return once(fields_, Place{&source, {}}, [&] { return library_.resolve(source); });
}

Result<Resolved<PointFieldAsset>> Preparation::resolve(const PointFieldSource& source, const MeshAsset& mesh) {
  if (std::holds_alternative<AssetSource>(source)) return library_.resolve(source, mesh);
  return once(points_, Place{&source, mesh.name.hash}, [&] { return library_.resolve(source, mesh); });
}

Result<Resolved<VertexValuesAsset>> Preparation::resolve(const VertexValuesSource& source) {
  if (!std::holds_alternative<FileSource>(source)) return library_.resolve(source);
  return once(values_, Place{&source, {}}, [&] { return library_.resolve(source); });
}

Result<Resolved<MovedVerticesAsset>> Preparation::resolve(const ResidueSource& source) {
  if (!std::holds_alternative<FileSource>(source)) return library_.resolve(source);
  return once(residues_, Place{&source, {}}, [&] { return library_.resolve(source); });
}

Result<void> Preparation::beforeWork(std::size_t triangles) {
  if (!mayGoThrough(static_cast<double>(triangles))) return refuseLongWork();
  return {};
}

/// Together with what was gone through for the edit before.
bool Preparation::mayGoThrough(double triangles) {
  if (mayTakeLong_) return true;
  if (gone_ + triangles > static_cast<double>(maxTriangles_)) return false;
  gone_ += triangles;
  return true;
}

const PreparedObject* Preparation::prepared(const std::string& name) const {
  const auto at = std::ranges::find(objects_, name, [](const PreparedObject& object) { return object.record.name; });
  return at == objects_.end() ? nullptr : &*at;
}

std::vector<std::shared_ptr<const Asset>> Preparation::made() const {
  std::vector<std::shared_ptr<const Asset>> made;
  for (const PreparedObject& object : objects_) {
    made.push_back(object.assets.mesh);
    made.insert(made.end(), object.assets.others.begin(), object.assets.others.end());
  }
  return made;
}

}  // namespace haptics
