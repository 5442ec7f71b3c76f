#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

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

/// The view with the first sample, which has the poses of driven objects; as it is where none comes.
std::shared_ptr<const MirrorView> withSample(Connection& connection, std::shared_ptr<const MirrorView> view) {
  constexpr int kLooks = 30;
  constexpr std::chrono::milliseconds kLook{10};
  for (int i = 0; i < kLooks && !view->sample; ++i) {
    std::this_thread::sleep_for(kLook);
    view = connection.link().latest();
  }
  return view;
}

}  // namespace

int get(const CommonOptions& common, const std::string& name) {
  constexpr double kSamples_Hz = 100;
  Connection connection(common, {.telemetryRate_Hz = kSamples_Hz});
  auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());
  if (!common.json) *view = withSample(connection, *view);
  const SceneVersion& scene = *(*view)->scene;
  if (!name.empty() && !scene.find(name)) {
    return fail(kRefused, {name, "no such object; the scene has: " + namesIn(scene)});
  }
  if (common.json) {
    std::cout << jsonOf(scene, name).line() << '\n';
  } else {
    std::cout << "# revision " << scene.revision() << ", root " << scene.root().hex() << '\n'
              << sceneText(**view, name);
  }
  return kDone;
}

}  // namespace haptics
