#include "haptic_server/scene/lost_parts.h"

#include <algorithm>
#include <utility>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics {
namespace {

TriMesh placeholderMesh() { return makeBox(Vec3(kPlaceholderSide_m), 1).value(); }

const ContentHash& placeholderHash() {
  static const ContentHash hash = hashOf(placeholderMesh());
  return hash;
}

/// Takes away what the refusal is of.
void dropPart(ObjectRecord& record, const std::string& field) {
  SurfaceProperties& surface = record.material.surface;
  if (field.starts_with("friction")) {
    surface.friction.reset();
  } else if (field.starts_with("texture")) {
    surface.texture.reset();
  } else if (field.starts_with("stiffness_over")) {
    surface.stiffnessOver.reset();
  } else if (field.starts_with("softness_over")) {
    surface.softnessOver.reset();
  } else if (field.starts_with("deformation")) {
    record.deformation.residue.reset();
  } else if (field.starts_with("shading")) {
    surface.shading.reset();
  } else if (field.starts_with("motion")) {
    record.motion.reset();
  } else {
    record.mesh = placeholderHash();
    surface = {};
    record.motion.reset();
    record.deformation = {};
  }
}

Result<ObjectAssets> gatherReady(const ObjectRecord& record, const AssetLookup& lookUp) {
  auto assets = gatherAssets(record, lookUp);
  if (!assets || !record.motion) return assets;
  // The mesh is restored; an edit of the object without it may have given it a motion that does not fit.
  (void)derive(record, *assets, {}, false, [](std::size_t) { return Result<void>(); });
  if (const auto& body = *assets->derived.body; !body) return tl::unexpected(Error(body.error()).within("motion."));
  return assets;
}

std::shared_ptr<const ObjectRecord> recordOf(const std::vector<std::shared_ptr<const ObjectRecord>>& records,
                                             ObjectId id) {
  const auto at = std::ranges::find(records, id, [](const auto& record) { return record->id; });
  return at == records.end() ? nullptr : *at;
}

}  // namespace

RecoveredObject recoverObject(ObjectRecord record, const AssetLookup& lookUp, AssetStore& store) {
  std::shared_ptr<const Asset> placeholder;
  const auto lookUpOrMake = [&](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
    auto asset = lookUp(name);
    if (asset || name.hash != placeholderHash()) return asset;
    placeholder = store.intern(placeholderMesh());
    return placeholder;
  };
  std::vector<std::string> lost;
  for (;;) {
    auto assets = gatherReady(record, lookUpOrMake);
    if (assets) return {std::move(record), *std::move(assets), std::move(lost)};
    lost.push_back(assets.error().text());
    dropPart(record, assets.error().field);
  }
}

ObjectRecord withLostParts(const ObjectRecord& now, const ObjectRecord& before) {
  ObjectRecord restored = now;
  if (now.mesh == placeholderHash()) restored.mesh = before.mesh;
  if (restored.mesh != before.mesh) return now;  // it has been given another
  SurfaceProperties& surface = restored.material.surface;
  const SurfaceProperties& itsSurface = before.material.surface;
  if (!surface.shading) surface.shading = itsSurface.shading;
  if (!surface.friction) surface.friction = itsSurface.friction;
  if (!surface.texture) surface.texture = itsSurface.texture;
  if (!surface.stiffnessOver) surface.stiffnessOver = itsSurface.stiffnessOver;
  if (!surface.softnessOver) surface.softnessOver = itsSurface.softnessOver;
  if (!restored.motion) restored.motion = before.motion;
  if (restored.deformation.empty()) restored.deformation = before.deformation;
  if (!restored.deformation.residue && restored.deformation.lattice == before.deformation.lattice)
    restored.deformation.residue = before.deformation.residue;
  return restored;
}

std::vector<std::string> lostParts(const ObjectRecord& now, const ObjectRecord& before) {
  const ObjectRecord restored = withLostParts(now, before);
  std::vector<std::string> parts;
  if (restored.mesh != now.mesh) parts.emplace_back("mesh");
  const SurfaceProperties& had = restored.material.surface;
  const SurfaceProperties& has = now.material.surface;
  if (had.shading != has.shading) parts.emplace_back("shading");
  if (had.friction != has.friction) parts.emplace_back("friction");
  if (had.texture != has.texture) parts.emplace_back("texture");
  if (had.stiffnessOver != has.stiffnessOver) parts.emplace_back("stiffness_over");
  if (had.softnessOver != has.softnessOver) parts.emplace_back("softness_over");
  if (restored.motion != now.motion) parts.emplace_back("motion");
  if (restored.deformation != now.deformation) parts.emplace_back("deformation");
  return parts;
}

std::vector<std::shared_ptr<const ObjectRecord>> stillLost(const SequencerState& state) {
  std::vector<std::shared_ptr<const ObjectRecord>> lost;
  for (const auto& before : state.lost) {
    const auto now = state.history->version.find(before->id);
    if (now && !(withLostParts(*now, *before) == *now)) lost.push_back(before);
  }
  return lost;
}

RestoredState restore(SequencerState state, const AssetLookup& lookUp, AssetStore& store, std::uint64_t freshEpoch) {
  RestoredState restored;
  const SceneVersion& version = state.history->version;
  Commit commit{.revision = version.revision() + 1, .prevRoot = version.root(), .put = {}, .removed = {}, .root = {}};
  std::vector<std::shared_ptr<const ObjectRecord>> stillGone;
  bool lostMore = false;
  for (const auto& now : version.objects()) {
    const auto before = recordOf(state.lost, now->id);
    const ObjectRecord complete = before ? withLostParts(*now, *before) : *now;
    RecoveredObject held = recoverObject(complete, lookUp, store);
    for (const std::string& part : held.lost) restored.warnings.push_back("object \"" + now->name + "\": " + part);
    if (!held.lost.empty()) stillGone.push_back(std::make_shared<const ObjectRecord>(complete));
    if (!(held.record == *now)) {
      if (held.lost.empty())
        restored.warnings.push_back("object \"" + now->name + "\": what was lost of it is here again");
      const bool lessThanNow = !(withLostParts(held.record, *now) == held.record);
      lostMore = lostMore || lessThanNow;
      held.record.revision = commit.revision;
      commit.put.push_back(held.record);
    }
    restored.assets[now->id] = std::move(held.assets);
  }
  state.lost = std::move(stillGone);
  if (!commit.put.empty()) {
    restored.changed = true;
    SceneHistory history = *state.history;
    auto next = version.apply(commit).value();  // the same objects by the same names
    commit.root = next.root();
    const std::uint64_t revision = commit.revision;
    history.append(std::make_shared<const AcceptedEdit>(
                       AcceptedEdit{kServerSession, revision, std::move(commit), restored.warnings, state.nextId}),
                   std::move(next));
    if (lostMore) history.epoch = freshEpoch;
    state.history = std::make_shared<const SceneHistory>(std::move(history));
  }
  restored.state = std::move(state);
  return restored;
}

}  // namespace haptics
