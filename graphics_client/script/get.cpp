#include <iostream>

#include "common/json/message_json.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/scene_text.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

Json jsonOf(const SceneVersion& scene, const std::string& name) {
  Json objects = Json::array();
  for (const auto& object : scene.objects()) {
    if (!name.empty() && object->name != name) continue;
    v1::ObjectState state;
    toWire(*object, state);
    objects.push(toJson(state));
  }
  return {{"revision", scene.revision()}, {"root", scene.root().hex()}, {"object", objects}};
}

std::string namesIn(const SceneVersion& scene) {
  std::string names;
  for (const auto& object : scene.objects()) names += (names.empty() ? "" : ", ") + object->name;
  return names.empty() ? "none" : names;
}

}  // namespace

int get(const CommonOptions& common, const std::string& name) {
  Connection connection(common, {});
  const auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());
  const SceneVersion& scene = *(*view)->scene;
  if (!name.empty() && !scene.find(name)) {
    return fail(kRefused, {name, "no such object; the scene has: " + namesIn(scene)});
  }
  if (common.json) {
    std::cout << jsonOf(scene, name).line() << '\n';
  } else {
    std::cout << "# revision " << scene.revision() << ", root " << scene.root().hex() << '\n' << sceneText(scene, name);
  }
  return kDone;
}

}  // namespace haptics
