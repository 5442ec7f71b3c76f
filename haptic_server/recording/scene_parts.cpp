#include "haptic_server/recording/scene_parts.h"

#include <algorithm>

#include "common/wire/convert.h"

namespace haptics {
namespace {

[[nodiscard]] const GivenObject* find(const std::vector<GivenObject>& objects, ObjectId id) {
  const auto at = std::ranges::lower_bound(objects, id, {}, &GivenObject::id);
  return at == objects.end() || at->id() != id ? nullptr : &*at;
}

/// But for whether it is leaving.
[[nodiscard]] bool isSame(const GivenObject& a, const GivenObject& b) {
  return *a.parts.record == *b.parts.record && a.parts.poseRevision == b.parts.poseRevision &&
         a.stiffness_N_per_m == b.stiffness_N_per_m && a.damping_Ns_per_m == b.damping_Ns_per_m &&
         a.torsion_Nm_per_rad == b.torsion_Nm_per_rad && a.baked == b.baked;
}

[[nodiscard]] std::string rootOf(const GivenScene& scene) {
  std::vector<ObjectRecord> records;
  for (const GivenObject& object : scene.objects) {
    if (!object.parts.pendingRemoval) records.push_back(*object.parts.record);
  }
  return SceneVersion::fromSnapshot(scene.revision, std::move(records)).value().root().asBytes();
}

}  // namespace

GivenScene givenScene(const ServoScene& scene, const std::vector<ServoObjectSource>& parts) {
  GivenScene given{scene.number, scene.revision, {}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ServoObject& object = scene.objects[i];
    given.objects.push_back(
        {parts[i], object.stiffness_N_per_m, object.damping_Ns_per_m, object.torsion_Nm_per_rad, object.baked});
  }
  return given;
}

void SceneParts::addAssets(const ServoObjectSource& object, const Put& put) {
  for (const AssetName& name : object.record->assets()) {
    const auto asset = object.assets.find(name.hash);
    if (!asset || !assets_.insert(name.hash).second) continue;
    v1::RecordingPart part;
    v1::RecordedAsset& message = *part.mutable_asset();
    message.set_kind(static_cast<v1::AssetKind>(name.kind));
    message.set_hash(name.hash.asBytes());
    message.set_data(asset->bytes().copy());
    put(part);
  }
}

void SceneParts::add(const GivenScene& scene, const Put& put) {
  v1::RecordingPart part;
  v1::RecordedScene& message = *part.mutable_scene();
  message.set_number(scene.number);
  message.set_revision(scene.revision);
  message.set_root(rootOf(scene));
  for (const GivenObject& object : scene.objects) {
    if (object.parts.pendingRemoval) message.add_leaving(object.id());
    if (const GivenObject* before = find(before_, object.id()); before != nullptr && isSame(*before, object)) continue;
    addAssets(object.parts, put);
    v1::RecordedObject& changed = *message.add_put();
    toWire(*object.parts.record, *changed.mutable_state());
    changed.set_posed_at(object.parts.poseRevision);
    changed.set_stiffness_n_per_m(object.stiffness_N_per_m);
    changed.set_damping_ns_per_m(object.damping_Ns_per_m);
    changed.set_torsion_nm_per_rad(object.torsion_Nm_per_rad);
    changed.set_shape(object.baked.shape);
    changed.set_dents_taken_up_to(object.baked.upTo);
    changed.set_dents_loosened_up_to(object.baked.releasedUpTo);
  }
  for (const GivenObject& object : before_) {
    if (find(scene.objects, object.id()) == nullptr) message.add_gone(object.id());
  }
  put(part);
  before_ = scene.objects;
}

}  // namespace haptics
