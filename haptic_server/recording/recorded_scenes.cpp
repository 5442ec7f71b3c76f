#include "haptic_server/recording/recorded_scenes.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/wire/convert.h"

namespace haptics {
namespace {

[[nodiscard]] Result<SceneVersion> versionOf(std::uint64_t revision, const std::vector<ServoObjectParts>& objects) {
  std::vector<ObjectRecord> records;
  for (const ServoObjectParts& object : objects) {
    if (!object.leaving) records.push_back(*object.record);
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

Result<ServoObjectParts> RecordedScenes::partsOf(const v1::RecordedObject& message) const {
  auto record = fromWire(message.state());
  if (!record) return tl::unexpected(std::move(record.error()));
  auto assets = gatherAssets(*record, [this](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
    const auto at = assets_.find(name.hash);
    if (at == assets_.end()) return refused("", "names an asset that the recording does not hold");
    return at->second;
  });
  if (!assets) return tl::unexpected(std::move(assets.error()));
  return ServoObjectParts{std::make_shared<const ObjectRecord>(*std::move(record)), *std::move(assets),
                          message.posed_at()};
}

Result<std::vector<ServoObjectParts>> RecordedScenes::objectsOf(const v1::RecordedScene& message) const {
  std::vector<ServoObjectParts> objects = maker_.parts();
  const auto idOf = [](const ServoObjectParts& object) { return object.record->id; };
  for (const ObjectId id : message.gone()) {
    if (std::erase_if(objects, [&](const auto& object) { return idOf(object) == id; }) == 0)
      return refused("gone", "names object " + std::to_string(id) + ", which was not there");
  }
  for (const v1::RecordedObject& object : message.put()) {
    auto parts = partsOf(object);
    if (!parts) return tl::unexpected(std::move(parts.error()).within("put."));
    const auto at = std::ranges::lower_bound(objects, idOf(*parts), {}, idOf);
    if (at != objects.end() && idOf(*at) == idOf(*parts)) {
      *at = *std::move(parts);
    } else {
      objects.insert(at, *std::move(parts));
    }
  }
  for (ServoObjectParts& object : objects) object.leaving = false;
  for (const ObjectId id : message.leaving()) {
    const auto at = std::ranges::lower_bound(objects, id, {}, idOf);
    if (at == objects.end() || idOf(*at) != id)
      return refused("leaving", "names object " + std::to_string(id) + ", which is not there");
    at->leaving = true;
  }
  if (objects.size() > kMaxServoObjects)
    return refused("put", "leads to more than " + std::to_string(kMaxServoObjects) + " objects");
  return objects;
}

Result<std::unique_ptr<const ServoScene>> RecordedScenes::make(const v1::RecordedScene& message) {
  if (message.number() == 0 || (number_ != 0 && message.number() != number_ + 1))
    return refused("scene.number", "is " + std::to_string(message.number()) + " after " + std::to_string(number_));
  const std::string where = "scene " + std::to_string(message.number()) + ": ";
  auto objects = objectsOf(message);
  if (!objects) return tl::unexpected(std::move(objects.error()).within(where));
  const auto version = versionOf(message.revision(), *objects);
  if (!version) return tl::unexpected(Error(version.error()).within(where));
  if (version->root().asBytes() != message.root()) return refused(where + "root", "is not that of its objects");
  auto scene = maker_.make(*std::move(objects), message.revision());
  scene->number = number_ = message.number();
  revision_ = message.revision();
  return scene;
}

Result<SceneVersion> RecordedScenes::version() const { return versionOf(revision_, maker_.parts()); }

}  // namespace haptics
