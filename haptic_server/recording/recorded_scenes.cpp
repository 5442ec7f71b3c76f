#include "haptic_server/recording/recorded_scenes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/driven_shapes.h"

namespace haptics {
namespace {

[[nodiscard]] Result<SceneVersion> versionOf(std::uint64_t revision, const std::vector<ServoObjectSource>& objects) {
  std::vector<ObjectRecord> records;
  for (const ServoObjectSource& object : objects) {
    if (!object.pendingRemoval) records.push_back(*object.record);
  }
  return SceneVersion::fromSnapshot(revision, std::move(records));
}

}  // namespace

Result<void> RecordedScenes::add(const v1::RecordedAsset& message) {
  const auto hash = hashFromWire(message.hash(), "asset.hash");
  if (!hash) return tl::unexpected(hash.error());
  const auto kind = assetKindFromWire(message.kind(), "asset.kind");
  if (!kind) return tl::unexpected(kind.error());
  auto asset = store_.internEncoded({*kind, *hash}, message.data());
  if (!asset) return tl::unexpected(std::move(asset.error()).within("asset."));
  assets_[*hash] = *std::move(asset);
  return {};
}

Result<ServoObjectSource> RecordedScenes::objectOf(const v1::RecordedObject& message) const {
  auto record = fromWire(message.state());
  if (!record) return tl::unexpected(std::move(record.error()));
  auto assets = gatherAssets(*record, [this](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
    const auto at = assets_.find(name.hash);
    if (at == assets_.end()) return refused("", "names an asset that the recording does not hold");
    return at->second;
  });
  if (!assets) return tl::unexpected(std::move(assets.error()));
  KinematicPose kinematic;
  if (message.has_drive()) {
    const auto pose = poseFromWire(message.drive().pose(), "drive.pose");
    if (!pose) return tl::unexpected(pose.error());
    if (record->movesByItself()) return refused("drive", "is of an object that moves by itself");
    kinematic = {message.drive().number(), *pose, kFirstSample_s};
  }
  DrivenShape shape;
  if (message.has_driven_shape()) {
    auto driven = shapeOf(message.driven_shape(), *record, *assets);
    if (!driven) return tl::unexpected(std::move(driven.error()).within("driven_shape."));
    shape = *std::move(driven);
  }
  return ServoObjectSource{.record = std::make_shared<const ObjectRecord>(*std::move(record)),
                           .assets = *std::move(assets),
                           .poseRevision = message.posed_at(),
                           .baked = {message.shape(), message.dents_taken_up_to(), message.dents_loosened_up_to()},
                           .kinematic = kinematic,
                           .shape = std::move(shape)};
}

Result<DrivenShape> RecordedScenes::shapeOf(const v1::RecordedShape& message, const ObjectRecord& record,
                                            const ObjectAssets& assets) const {
  if (!hasRoom_) return refused("number", "is there, and the head's limits are those of fewer hands");
  if (const auto why = whyNotReshaped(record)) return refused("number", "is of an object that " + *why);
  const auto samples = static_cast<std::size_t>(message.sample_size());
  if (samples < 2 || samples > ShapeSamples::kMax || message.number() < samples - 1)
    return refused("sample",
                   "is there " + std::to_string(samples) + " times, up to number " + std::to_string(message.number()));
  DrivenShape shape{.number = message.number(), .samples = {}};
  for (const v1::Lattice& lattice : message.sample()) {
    auto sample = sampleOf(lattice, record, assets);
    if (!sample) return tl::unexpected(std::move(sample.error()).within("sample."));
    shape.samples.push_back(*std::move(sample));
  }
  return shape;
}

/// The last scene's where that has the same.
Result<std::shared_ptr<const DrivenShape::Sample>> RecordedScenes::sampleOf(const v1::Lattice& message,
                                                                            const ObjectRecord& record,
                                                                            const ObjectAssets& assets) const {
  auto lattice = announcedLatticeFrom(message);
  if (!lattice) return tl::unexpected(std::move(lattice.error()));
  if (!*lattice) return std::make_shared<const DrivenShape::Sample>(ownShape(record, assets));
  const auto last = std::ranges::lower_bound(objects_, record.id, {}, &ServoObjectSource::id);
  if (last != objects_.end() && last->id() == record.id && last->record->mesh == record.mesh) {
    const auto& samples = last->shape.samples;
    const auto same = std::ranges::find_if(samples, [&](const auto& sample) { return sample->lattice == *lattice; });
    if (same != samples.end()) return *same;
  }
  auto sample = shapeSample(record, assets, **std::move(lattice), false);
  if (!sample) return tl::unexpected(std::move(sample.error()));
  return std::make_shared<const DrivenShape::Sample>(*std::move(sample));
}

Result<void> RecordedScenes::takeFelt(const v1::RecordedObject& message, const ServoObjectSource& object) {
  const double stiffness = message.stiffness_n_per_m(), damping = message.damping_ns_per_m();
  if (!std::isfinite(stiffness) || stiffness < 0) return refused("stiffness_N_per_m", "is not finite and at least 0");
  if (!std::isfinite(damping) || damping < 0) return refused("damping_Ns_per_m", "is not finite and at least 0");
  const double torsion = message.torsion_nm_per_rad();
  const bool isTool = object.record->motion && object.record->motion->tool;
  if (!std::isfinite(torsion) || torsion < 0 || (isTool && torsion == 0))
    return refused("torsion_Nm_per_rad", "is not finite and at least 0, of a tool above 0");
  felt_[object.id()] = {stiffness, damping, torsion};
  return {};
}

Result<std::vector<ServoObjectSource>> RecordedScenes::objectsOf(const v1::RecordedScene& message) {
  std::vector<ServoObjectSource> objects = objects_;
  for (const ObjectId id : message.gone()) {
    if (std::erase_if(objects, [id](const ServoObjectSource& object) { return object.id() == id; }) == 0)
      return refused("gone", "names object " + std::to_string(id) + ", which was not there");
  }
  for (const v1::RecordedObject& put : message.put()) {
    auto object = objectOf(put);
    if (!object) return tl::unexpected(std::move(object.error()).within("put."));
    if (feltAsRecorded_) {
      if (auto felt = takeFelt(put, *object); !felt) return tl::unexpected(std::move(felt.error()).within("put."));
    }
    const auto at = std::ranges::lower_bound(objects, object->id(), {}, &ServoObjectSource::id);
    if (at != objects.end() && at->id() == object->id()) {
      *at = *std::move(object);
    } else {
      objects.insert(at, *std::move(object));
    }
  }
  for (ServoObjectSource& object : objects) object.pendingRemoval = false;
  for (const ObjectId id : message.leaving()) {
    const auto at = std::ranges::lower_bound(objects, id, {}, &ServoObjectSource::id);
    if (at == objects.end() || at->id() != id)
      return refused("leaving", "names object " + std::to_string(id) + ", which is not there");
    at->pendingRemoval = true;
  }
  if (objects.size() > kMaxServoObjects)
    return refused("put", "leads to more than " + std::to_string(kMaxServoObjects) + " objects");
  return objects;
}

Result<RemadeScene> RecordedScenes::make(const v1::RecordedScene& message) {
  if (message.number() == 0 || (number_ != 0 && message.number() != number_ + 1))
    return refused("scene.number", "is " + std::to_string(message.number()) + " after " + std::to_string(number_));
  const std::string where = "scene " + std::to_string(message.number()) + ": ";
  auto objects = objectsOf(message);
  if (!objects) return tl::unexpected(std::move(objects.error()).within(where));
  auto version = versionOf(message.revision(), *objects);
  if (!version) return tl::unexpected(Error(version.error()).within(where));
  if (version->root().asBytes() != message.root()) return refused(where + "root", "is not that of its objects");
  objects_ = *std::move(objects);
  auto scene = builder_.make(objects_, message.revision());
  scene->number = number_ = message.number();
  for (ServoObject& object : scene->objects) {
    if (const auto felt = felt_.find(object.id); felt != felt_.end())
      std::tie(object.stiffness_N_per_m, object.damping_Ns_per_m, object.torsion_Nm_per_rad) =
          std::tie(felt->second.stiffness_N_per_m, felt->second.damping_Ns_per_m, felt->second.torsion_Nm_per_rad);
  }
  return RemadeScene{std::move(scene), *std::move(version), objects_};
}

}  // namespace haptics
