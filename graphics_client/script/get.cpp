#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "common/json/message_json.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/scene_file.h"
#include "graphics_client/editing/scene_text.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

constexpr const char* kByHash =
    "# Of assets by their hash, which this server holds; into a file (> FILE) they would be written beside it.\n";

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

/// The file that standard output goes into; empty: it goes somewhere else.
std::filesystem::path standardOutputFile() {
  struct stat status {};
  if (fstat(STDOUT_FILENO, &status) != 0 || !S_ISREG(status.st_mode)) return {};
  std::error_code error;
  const auto file = std::filesystem::read_symlink("/proc/self/fd/1", error);
  return std::filesystem::exists(file, error) ? file : std::filesystem::path();
}

/// The view with all assets; as it is where they do not come in time.
std::shared_ptr<const MirrorView> withAssets(Connection& connection, std::shared_ptr<const MirrorView> view) {
  const auto isWhole = [](const MirrorView& v) {
    return std::ranges::all_of(v.scene->objects(), [&v](const auto& object) { return v.isComplete(*object); });
  };
  auto whole = connection.link().waitUntil(isWhole, connection.timeout());
  return whole ? whole : view;
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
  Connection connection(common, {.telemetryRate_Hz = kSamples_Hz, .meshes = !common.json});
  auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());
  const auto file = common.json ? std::filesystem::path() : standardOutputFile();
  if (!common.json) *view = withSample(connection, *view);
  if (!common.json) *view = withAssets(connection, *view);
  const SceneVersion& scene = *(*view)->scene;
  if (!name.empty() && !scene.find(name)) {
    return fail(kRefused, {name, "no such object; the scene has: " + namesIn(scene)});
  }
  if (common.json) {
    std::cout << jsonOf(scene, name).line() << '\n';
  } else {
    const auto text = sceneFor(file.empty() ? std::nullopt : std::optional(file.parent_path()), **view, name);
    if (!text) return fail(kRefused, text.error());
    std::cout << "# revision " << scene.revision() << ", root " << scene.root().hex() << '\n'
              << (text->find("asset: ") == std::string::npos ? "" : kByHash) << *text;
  }
  return kDone;
}

}  // namespace haptics
