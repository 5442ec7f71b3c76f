#include "graphics_client/mirror/mirror.h"

#include <algorithm>
#include <map>
#include <set>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"
#include "graphics_client/mirror/client_limits.h"

namespace haptics {
namespace {

auto rootsDiffer(const char* field, std::uint64_t revision, const ContentHash& own, const ContentHash& server) {
  return refused(field, "differs at revision " + std::to_string(revision) + ": " + own.hex() + " here, " +
                            server.hex() + " at the server");
}

std::set<AssetName> assetsOf(const SceneVersion& scene) {
  std::set<AssetName> names;
  for (const SceneVersion::Object& object : scene.objects()) {
    const auto its = object->assets();
    names.insert(its.begin(), its.end());
  }
  return names;
}

/// An asset's content, hashed anew.
struct HeldAsset {
  std::size_t bytes;
  ContentHash hash;
};

std::size_t sizeOf(const TriMesh& mesh) {
  return sizeof(Vec3f) * mesh.vertices.size() + sizeof(TriangleIndices) * mesh.triangles.size();
}
std::size_t sizeOf(const SampledField& field) { return field.samples().size_bytes(); }
std::size_t sizeOf(const std::vector<float>& values) { return sizeof(float) * values.size(); }
std::size_t sizeOf(const MovedVertices& moved) { return (sizeof(std::uint32_t) + sizeof(Vec3f)) * moved.vertex.size(); }
std::size_t sizeOf(const PointField& field) { return field.samples().size_bytes(); }

/// Visits the assets of every kind, as visit(kind, map).
template <class View, class Visit>
void forEachKind(View& view, const Visit& visit) {
  visit(AssetKind::kMesh, view.meshes);
  visit(AssetKind::kScalarField, view.fields);
  visit(AssetKind::kVertexValues, view.vertexValues);
  visit(AssetKind::kMovedVertices, view.movedVertices);
  visit(AssetKind::kPointField, view.pointFields);
}

std::optional<HeldAsset> heldAsset(const MirrorView& view, const AssetName& name) {
  std::optional<HeldAsset> found;
  forEachKind(view, [&](AssetKind kind, const auto& held) {
    const auto at = kind == name.kind ? held.find(name.hash) : held.end();
    if (at != held.end()) found = HeldAsset{sizeOf(*at->second), hashOf(*at->second)};
  });
  return found;
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
    view_.secondHand.reset();
    view_.bodies.clear();
    view_.shapes.clear();
    view_.dents.clear();
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
  if (next->objects().size() > kMaxHeldObjects) {
    return refused("put", "leads to more than " + std::to_string(kMaxHeldObjects) + " objects");
  }
  if (next->root() != commit.root) return rootsDiffer("root", commit.revision, next->root(), commit.root);
  setScene(std::move(*next));
  return {};
}

Result<void> Mirror::addAsset(const AssetName& name, std::string_view bytes) {
  auto content = decodeAsset(name.kind, bytes);
  if (!content) return tl::unexpected<Error>(std::move(content.error()).within("asset " + name.hash.hex() + " "));
  return addAsset(name, *std::move(content));
}

Result<void> Mirror::addAsset(const AssetName& name, AssetContent content) {
  if (kindOf(content) != name.kind) return refused("asset " + name.hash.hex(), "is of another kind than its name says");
  if (const ContentHash own = canonicalBytes(content).hash(); own != name.hash) {
    return refused("asset " + name.hash.hex(), "its content hashes to " + own.hex());
  }
  if (!assetsOf(scene()).contains(name)) return {};
  forEachKind(view_, [&](AssetKind kind, auto& held) {
    using Asset = typename std::remove_reference_t<decltype(held)>::mapped_type;
    if (kind == name.kind) held[name.hash] = std::get<Asset>(std::move(content));
  });
  countAssets();
  compare();
  return {};
}

Result<void> Mirror::audit(std::size_t assetBytes) {
  std::vector<ObjectRecord> records;
  for (const SceneVersion::Object& object : scene().objects()) records.push_back(*object);
  const auto anew = SceneVersion::fromSnapshot(scene().revision(), std::move(records));
  if (!anew || anew->root() != scene().root()) return refused("memory", "holds other records than it was given");
  const std::set<AssetName> named = assetsOf(scene());
  std::size_t done_bytes = 0;
  for (std::size_t left = named.size(); left > 0 && done_bytes < assetBytes; --left) {
    auto next = named.upper_bound(lastAudited_);
    if (next == named.end()) next = named.begin();
    lastAudited_ = *next;
    const auto held = heldAsset(view_, *next);
    if (!held) continue;
    done_bytes += held->bytes;
    if (held->hash == next->hash) continue;
    drop(*next);
    return refused("memory", "holds another asset " + next->hash.hex() + " than it was given");
  }
  return {};
}

bool Mirror::take(const TelemetrySample& sample, std::span<const BodyState> bodies, std::vector<ObjectDent> dents,
                  const std::optional<ToolState>& tool, const std::optional<TelemetrySample>& secondHand,
                  std::vector<ShapeState> shapes) {
  if (newestTick_ && sample.tick <= *newestTick_) return false;
  newestTick_ = sample.tick;
  view_.sample = sample;
  view_.secondHand = secondHand;
  // What is driven was so in the scene that the sample is of: an edit since may have put it back.
  const auto isOf = [&](const SceneVersion::Object& object) { return sample.sceneRevision >= object->revision; };
  for (const BodyState& body : bodies) {
    const auto object = scene().find(body.object);
    if (object && (object->movesByItself() || isOf(object))) view_.bodies[body.object] = body;
  }
  for (ShapeState& shape : shapes) {
    const auto object = scene().find(shape.object);
    if (object && isOf(object)) view_.shapes[shape.object] = std::move(shape.lattice);
  }
  view_.dents = std::move(dents);
  view_.tool = tool;
  ++view_.samplesReceived;
  return true;
}

std::vector<AssetName> Mirror::lackingAssets() const {
  std::vector<AssetName> lacking;
  std::set<AssetName> seen;
  for (const SceneVersion::Object& object : scene().objects()) {
    for (const AssetName& asset : object->assets()) {
      if (!view_.holds(asset) && seen.insert(asset).second) lacking.push_back(asset);
    }
  }
  return lacking;
}

/// Assets that the new scene does not name are let go: a client's memory follows the scene's size.
void Mirror::setScene(SceneVersion scene) {
  const std::set<AssetName> named = assetsOf(scene);
  forEachKind(view_, [&](AssetKind kind, auto& held) {
    std::erase_if(held, [&](const auto& entry) { return !named.contains({kind, entry.first}); });
  });
  const auto isOther = [&](const SceneVersion::Object& object) {
    const auto before = view_.scene->find(object->id);
    return !before || before->revision != object->revision;  // pose or shape come again where it still is driven
  };
  std::erase_if(view_.bodies, [&](const auto& entry) {
    const auto object = scene.find(entry.first);
    return !object || (!object->movesByItself() && isOther(object));
  });
  std::erase_if(view_.shapes, [&](const auto& entry) {
    const auto object = scene.find(entry.first);
    return !object || isOther(object);
  });
  view_.scene = std::make_shared<const SceneVersion>(std::move(scene));
  countAssets();
  compare();
}

void Mirror::drop(const AssetName& asset) {
  forEachKind(view_, [&](AssetKind kind, auto& held) {
    if (kind == asset.kind) held.erase(asset.hash);
  });
  countAssets();
}

void Mirror::countAssets() {
  view_.assetBytes = 0;
  forEachKind(view_, [&](AssetKind, const auto& held) {
    for (const auto& [hash, asset] : held) view_.assetBytes += sizeOf(*asset);
  });
}

void Mirror::compare() {
  view_.hashesEqual = view_.epoch != 0 && view_.serverRevision == scene().revision() &&
                      view_.serverRoot == scene().root() && lackingAssets().empty();
}

bool MirrorView::holds(const AssetName& asset) const {
  bool isHeld = false;
  forEachKind(*this,
              [&](AssetKind kind, const auto& held) { isHeld |= kind == asset.kind && held.contains(asset.hash); });
  return isHeld;
}

std::optional<AssetContent> MirrorView::contentOf(const AssetName& asset) const {
  std::optional<AssetContent> content;
  forEachKind(*this, [&](AssetKind kind, const auto& held) {
    const auto at = kind == asset.kind ? held.find(asset.hash) : held.end();
    if (at != held.end()) content = at->second;
  });
  return content;
}

Pose MirrorView::poseOf(const ObjectRecord& object) const {
  const auto at = bodies.find(object.id);
  return at == bodies.end() ? object.pose : at->second.pose;
}

DeformationProperties MirrorView::deformationOf(const ObjectRecord& object) const {
  DeformationProperties deformation = object.deformation;
  const auto at = shapes.find(object.id);
  if (at == shapes.end() || !at->second) return deformation;
  deformation.lattice = at->second;
  deformation.residue.reset();
  return deformation;
}

std::vector<Dent> MirrorView::dentsIn(const ObjectRecord& object) const {
  std::vector<Dent> own;
  if (!object.deformation.softness) return own;
  for (const ObjectDent& dent : dents) {
    if (dent.object == object.id) own.push_back(dent.dent);
  }
  return own;
}

std::optional<std::array<Vec3, 3>> MirrorView::cornersOf(const ObjectRecord& object, std::uint32_t triangle) const {
  const auto mesh = meshes.find(object.mesh);
  if (mesh == meshes.end() || triangle >= mesh->second->triangles.size()) return std::nullopt;
  std::array<Vec3f, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh->second->vertices[mesh->second->triangles[triangle][k]];
  const DeformationProperties deformation = deformationOf(object);
  if (deformation.lattice) std::ranges::copy(shapedBy(*deformation.lattice, corners), corners.begin());
  if (deformation.residue) {
    const auto residue = movedVertices.find(*deformation.residue);
    if (residue == movedVertices.end()) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = residue->second->placeOf(mesh->second->triangles[triangle][k]);
      corners[k] = place.value_or(corners[k]);
    }
  }
  if (const std::vector<Dent> own = dentsIn(object); !own.empty()) {
    const Falloff falloff = tissueOf(*object.deformation.softness).falloff;
    for (Vec3f& corner : corners) corner = dented(corner, own, falloff);
  }
  return std::array{Vec3(corners[0]), Vec3(corners[1]), Vec3(corners[2])};
}

bool MirrorView::isComplete(const ObjectRecord& object) const {
  return std::ranges::all_of(object.assets(), [this](const AssetName& asset) { return holds(asset); });
}

Result<ContentHash> recomputedRoot(const MirrorView& view) {
  std::map<AssetName, ContentHash> anew;
  for (const AssetName& asset : assetsOf(*view.scene)) {
    if (const auto held = heldAsset(view, asset)) anew[asset] = held->hash;
  }
  std::vector<ObjectRecord> records;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    for (const AssetName& asset : object->assets()) {
      if (anew.contains(asset)) continue;
      const char* what = asset.kind == AssetKind::kMesh            ? "its mesh"
                         : asset.kind == AssetKind::kMovedVertices ? "its residue"
                                                                   : "an asset of its surface";
      return refused("object \"" + object->name + "\"", std::string(what) + " has not arrived");
    }
    ObjectRecord& record = records.emplace_back(*object);
    record.mesh = anew.at({AssetKind::kMesh, record.mesh});
    record.material.surface =
        renamed(std::move(record.material.surface), [&anew](const AssetName& asset) { return anew.at(asset); });
    if (auto& residue = record.deformation.residue) *residue = anew.at({AssetKind::kMovedVertices, *residue});
  }
  auto scene = SceneVersion::fromSnapshot(view.scene->revision(), std::move(records));
  if (!scene) return tl::unexpected<Error>(scene.error());
  return scene->root();
}

std::optional<ContentHash> deformedHash(const MirrorView& view) {
  const auto find = [](const auto& held, const ContentHash& hash) {
    const auto at = held.find(hash);
    return at == held.end() ? nullptr : at->second.get();
  };
  const HeldShapes held{.vertices = [&](const ContentHash& mesh) -> const std::vector<Vec3f>* {
                          const TriMesh* known = find(view.meshes, mesh);
                          return known == nullptr ? nullptr : &known->vertices;
                        },
                        .residue = [&](const ContentHash& residue) { return find(view.movedVertices, residue); }};
  return deformedHash(*view.scene, held, view.dents);
}

}  // namespace haptics
