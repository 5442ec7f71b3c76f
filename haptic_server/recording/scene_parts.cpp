#include "haptic_server/recording/scene_parts.h"

#include <algorithm>

#include "common/wire/convert.h"
#include "common/wire/driven_shapes.h"

namespace haptics {
namespace {

[[nodiscard]] const ServoObjectSource* find(const std::vector<ServoObjectSource>& objects, ObjectId id) {
  const auto at = std::ranges::lower_bound(objects, id, {}, &ServoObjectSource::id);
  return at == objects.end() || at->id() != id ? nullptr : &*at;
}

/// But for whether it is leaving, which RecordedScene lists. Binds every member: a new one does not compile until it is
/// recorded, or known to follow from the others.
[[nodiscard]] bool isSame(const ServoObjectSource& a, const ServoObjectSource& b) {
  const auto& [record, assets, poseRevision, pendingRemoval, baked, kinematic, shape] = a;
  return *record == *b.record && poseRevision == b.poseRevision && baked == b.baked && kinematic == b.kinematic &&
         shape == b.shape;
}

[[nodiscard]] std::string rootOf(const SceneSource& scene) {
  std::vector<ObjectRecord> records;
  for (const ServoObjectSource& object : scene.objects) {
    if (!object.pendingRemoval) records.push_back(*object.record);
  }
  return SceneVersion::fromSnapshot(scene.revision, std::move(records)).value().root().asBytes();
}

}  // namespace

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

void SceneParts::add(const SceneSource& scene, const Put& put) {
  v1::RecordingPart part;
  v1::RecordedScene& message = *part.mutable_scene();
  message.set_number(scene.number);
  message.set_revision(scene.revision);
  message.set_root(rootOf(scene));
  for (const ServoObjectSource& object : scene.objects) {
    if (object.pendingRemoval) message.add_leaving(object.id());
    if (const ServoObjectSource* before = find(before_, object.id()); before != nullptr && isSame(*before, object))
      continue;
    addAssets(object, put);
    v1::RecordedObject& changed = *message.add_put();
    toWire(*object.record, *changed.mutable_state());
    changed.set_posed_at(object.poseRevision);
    changed.set_shape(object.baked.shape);
    changed.set_dents_taken_up_to(object.baked.upTo);
    changed.set_dents_loosened_up_to(object.baked.releasedUpTo);
    if (object.kinematic.number != 0) {
      changed.mutable_drive()->set_number(object.kinematic.number);
      toWire(object.kinematic.pose, *changed.mutable_drive()->mutable_pose());
    }
    if (object.shape.number == 0) continue;
    changed.mutable_driven_shape()->set_number(object.shape.number);
    for (const auto& sample : object.shape.samples) {
      v1::Lattice& lattice = *changed.mutable_driven_shape()->add_sample();
      if (sample->lattice) toWire(*sample->lattice, lattice);
    }
  }
  for (const ServoObjectSource& object : before_) {
    if (find(scene.objects, object.id()) == nullptr) message.add_gone(object.id());
  }
  put(part);
  before_ = scene.objects;
}

}  // namespace haptics
