#include "graphics_client/mirror/mirror.h"

#include <algorithm>
#include <set>

#include "common/mesh/mesh_asset.h"

namespace haptics {
namespace {

auto rootsDiffer(const char* field, std::uint64_t revision, const ContentHash& own, const ContentHash& server) {
  return refused(field, "differs at revision " + std::to_string(revision) + ": " + own.hex() + " here, " +
                            server.hex() + " at the server");
}

}  // namespace

void Mirror::announce(std::uint64_t revision, const ContentHash& root) {
  view_.serverRevision = revision;
  view_.serverRoot = root;
  compare();
}

Result<void> Mirror::replaceScene(std::uint64_t epoch, SceneVersion scene, const ContentHash& root) {
  if (scene.root() != root) return rootsDiffer("root", scene.revision(), scene.root(), root);
  if (view_.epoch != 0 && view_.epoch != epoch) {
    ++view_.stateResets;
    view_.sample.reset();
  }
  view_.epoch = epoch;
  setScene(std::move(scene));
  return {};
}

Result<void> Mirror::apply(const Commit& commit) {
  if (commit.prevRoot != scene().root()) {
    return rootsDiffer("prev_root", scene().revision(), scene().root(), commit.prevRoot);
  }
  auto next = scene().apply(commit);
  if (!next) return tl::unexpected<Error>(next.error());
  if (next->root() != commit.root) return rootsDiffer("root", commit.revision, next->root(), commit.root);
  setScene(std::move(*next));
  return {};
}

Result<void> Mirror::addMesh(const ContentHash& hash, std::string_view bytes) {
  auto mesh = decodeMesh(bytes);
  if (!mesh) return tl::unexpected<Error>(std::move(mesh.error()).within("mesh " + hash.hex() + " "));
  if (const ContentHash own = hashOf(*mesh); own != hash) {
    return refused("mesh " + hash.hex(), "its content hashes to " + own.hex());
  }
  const auto named = [&](const SceneVersion::Object& object) { return object->mesh == hash; };
  if (std::ranges::any_of(scene().objects(), named)) {
    view_.meshes[hash] = std::make_shared<const TriMesh>(std::move(*mesh));
    compare();
  }
  return {};
}

Result<void> Mirror::audit(std::size_t meshBytes) {
  std::vector<ObjectRecord> records;
  for (const SceneVersion::Object& object : scene().objects()) records.push_back(*object);
  const auto anew = SceneVersion::fromSnapshot(scene().revision(), std::move(records));
  if (!anew || anew->root() != scene().root()) return refused("memory", "holds other records than it was given");
  std::size_t done_bytes = 0;
  for (std::size_t left = view_.meshes.size(); left > 0 && done_bytes < meshBytes; --left) {
    auto mesh = view_.meshes.upper_bound(lastAudited_);
    if (mesh == view_.meshes.end()) mesh = view_.meshes.begin();
    lastAudited_ = mesh->first;
    done_bytes +=
        sizeof(Vec3f) * mesh->second->vertices.size() + sizeof(TriangleIndices) * mesh->second->triangles.size();
    if (hashOf(*mesh->second) == mesh->first) continue;
    view_.meshes.erase(mesh);
    return refused("memory", "holds another mesh " + lastAudited_.hex() + " than it was given");
  }
  return {};
}

bool Mirror::take(const TelemetrySample& sample) {
  if (newestTick_ && sample.tick <= *newestTick_) return false;
  newestTick_ = sample.tick;
  view_.sample = sample;
  ++view_.samplesReceived;
  return true;
}

std::vector<ContentHash> Mirror::lackingMeshes() const {
  std::vector<ContentHash> lacking;
  std::set<ContentHash> seen;
  for (const SceneVersion::Object& object : scene().objects()) {
    if (!view_.meshes.contains(object->mesh) && seen.insert(object->mesh).second) lacking.push_back(object->mesh);
  }
  return lacking;
}

/// Meshes that the new scene does not name are let go: a client's memory follows the scene's size.
void Mirror::setScene(SceneVersion scene) {
  std::set<ContentHash> named;
  for (const SceneVersion::Object& object : scene.objects()) named.insert(object->mesh);
  std::erase_if(view_.meshes, [&](const auto& entry) { return !named.contains(entry.first); });
  view_.scene = std::make_shared<const SceneVersion>(std::move(scene));
  compare();
}

void Mirror::compare() {
  view_.hashesEqual = view_.epoch != 0 && view_.serverRevision == scene().revision() &&
                      view_.serverRoot == scene().root() && lackingMeshes().empty();
}

Result<ContentHash> recomputedRoot(const MirrorView& view) {
  std::vector<ObjectRecord> records;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    const auto mesh = view.meshes.find(object->mesh);
    if (mesh == view.meshes.end()) return refused("object \"" + object->name + "\"", "its mesh has not arrived");
    records.push_back(*object);
    records.back().mesh = hashOf(*mesh->second);
  }
  auto scene = SceneVersion::fromSnapshot(view.scene->revision(), std::move(records));
  if (!scene) return tl::unexpected<Error>(scene.error());
  return scene->root();
}

}  // namespace haptics
