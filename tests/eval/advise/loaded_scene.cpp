#include "tests/eval/advise/loaded_scene.h"

#include "common/wire/convert.h"
#include "haptic_server/scene/scene_room.h"

namespace haptics::eval {

Result<std::vector<LoadedObject>> loadScene(const std::string& file, std::vector<std::filesystem::path> assets) {
  const auto message = readSceneFile(file);
  if (!message) return tl::unexpected(message.error());
  auto transaction = fromWire(*message);
  if (!transaction) return tl::unexpected(std::move(transaction.error()).within(file + ": "));
  assets.insert(assets.begin(), std::filesystem::absolute(file).parent_path());
  SceneCrossing crossing;
  SceneRoom room({.assetFolders = std::move(assets), .makePlan = {}, .log = {}}, crossing);
  auto reports = room.loadStartScene(*transaction);
  if (!reports) return tl::unexpected(std::move(reports.error()).within(file + ": "));

  std::vector<LoadedObject> objects;
  for (const auto& record : room.history()->version.objects()) {
    const auto asset = as<MeshAsset>(room.findAsset(record->mesh));
    objects.push_back({record->name, record->material, record->pose, asset->mesh, asset->surface});
  }
  if (objects.empty()) return refused(file, "holds no object that could be touched");
  return objects;
}

ServoScene servoSceneOf(const std::vector<LoadedObject>& objects) {
  ServoScene scene;
  scene.revision = 1;
  for (const LoadedObject& object : objects) {
    scene.objects.push_back({scene.objects.size() + 1, object.surface, object.pose, object.material.stiffness_N_per_m,
                             object.material.damping_Ns_per_m, false});
  }
  return scene;
}

}  // namespace haptics::eval
