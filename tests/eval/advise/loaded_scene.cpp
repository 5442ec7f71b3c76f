#include "tests/eval/advise/loaded_scene.h"

#include <algorithm>

#include "common/wire/convert.h"
#include "haptic_server/scene/scene_service.h"

namespace haptics::eval {

Result<std::vector<LoadedObject>> loadScene(const std::string& file, std::vector<std::filesystem::path> assets) {
  const auto message = readSceneFile(file);
  if (!message) return tl::unexpected(message.error());
  auto transaction = fromWire(*message);
  if (!transaction) return tl::unexpected(std::move(transaction.error()).within(file + ": "));
  assets.insert(assets.begin(), std::filesystem::absolute(file).parent_path());
  SceneMailbox mailbox;
  SceneService sceneService({.assetFolders = std::move(assets), .makePlan = {}, .log = {}}, mailbox);
  auto reports = sceneService.loadStartScene(*transaction);
  if (!reports) return tl::unexpected(std::move(reports.error()).within(file + ": "));

  const ServoScene* servoScene = mailbox.newest();
  std::vector<LoadedObject> objects;
  for (const auto& record : sceneService.history()->version.objects()) {
    const auto asset = as<MeshAsset>(sceneService.findAsset(record->mesh));
    objects.push_back({record->name, record->material, record->pose, asset->mesh, asset->surface, record->motion,
                       record->deformation});
    objects.back().effects = record->effects;
    const auto felt = std::ranges::find(servoScene->objects, record->id, &ServoObject::id);
    if (felt != servoScene->objects.end()) objects.back().detail = felt->detail;
  }
  if (objects.empty()) return refused(file, "holds no object that could be touched");
  return objects;
}

std::shared_ptr<const SurfaceDetail> shadingOf(const Material& material, const CollisionMesh& surface) {
  if (!material.surface.shading) return nullptr;
  SurfaceProperties properties;
  properties.shading = Shading{material.surface.shading->crease_rad, {}};
  return makeSurfaceDetail(surface, properties, {});
}

ServoScene servoSceneOf(const std::vector<LoadedObject>& objects) {
  ServoScene scene;
  scene.revision = 1;
  for (const LoadedObject& object : objects) {
    scene.objects.push_back({scene.objects.size() + 1, object.surface, object.pose, object.material.stiffness_N_per_m,
                             object.material.damping_Ns_per_m, false, object.detail});
  }
  return scene;
}

}  // namespace haptics::eval
