// What a draft's operations name is made, and looked at whether it fits together.
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <variant>

#include "common/telemetry/motion_state.h"
#include "haptic_server/scene/effect_limits.h"
#include "haptic_server/scene/fit_to_mesh.h"
#include "haptic_server/scene/overlap_warnings.h"
#include "haptic_server/scene/scene_draft.h"

namespace haptics {

Result<std::vector<std::string>> SceneDraft::resolve(AssetResolver& resolver) {
  constexpr std::array<const char*, 7> kOf{"",           "friction: ", "dynamic friction: ", "texture: ", "stiffness: ",
                                           "softness: ", "residue: "};  // as Place counts
  std::vector<std::string> reports;
  if (auto affordable = checkPrice(resolver); !affordable) return tl::unexpected(std::move(affordable).error());
  // What grows on a mesh comes after all meshes.
  const auto grown = std::stable_partition(pendingAssets_.begin(), pendingAssets_.end(), [](const PendingAsset& named) {
    return !std::holds_alternative<const GrownSource*>(named.source);
  });
  for (auto at = pendingAssets_.begin();; ++at) {
    if (at == grown) {
      if (auto affordable = checkPrice(resolver); !affordable) return tl::unexpected(std::move(affordable).error());
    }
    if (at == pendingAssets_.end()) break;
    const PendingAsset& named = *at;
    auto report = make(named, resolver);
    if (!report) return tl::unexpected(std::move(report).error().within(named.field));
    if (!report->empty()) reports.push_back(named.name + ": " + kOf[static_cast<std::size_t>(named.place)] + *report);
  }
  if (auto fits = checkDetailSizes(); !fits) return tl::unexpected(std::move(fits).error());
  for (const PendingAsset& named : pendingAssets_) fitMapping(named);
  EffectZones effects;
  forEachRecord([&](const ObjectRecord& record) { effects.add(record); });
  const auto addWarnings = [&](const ObjectRecord& record, const ObjectAssets& assets) {
    for (const std::string& warning : resolver.warnings(record, assets, effects))
      reports.push_back(record.name + ": " + warning);
  };
  for (const auto& [object, given] : fieldPaths_) {
    ObjectRecord& record = *put(object);
    if (auto gathered = gather(record, given, resolver); !gathered) return tl::unexpected(std::move(gathered).error());
    if (auto fits = fitDeformation(record, given); !fits) return tl::unexpected(std::move(fits).error());
    auto derived =
        derive(record, assets_.at(object), known(record, resolver), !(given.mesh.empty() && given.deformation.empty()),
               [&resolver](std::size_t triangles) { return resolver.beforeWork(triangles); });
    if (!derived) return tl::unexpected(std::move(derived).error());
    if (auto moves = checkMotion(record, given); !moves) return tl::unexpected(std::move(moves).error());
    if (auto fit = checkEffects(record, *assets_.at(object).mesh, given.mesh); !fit)
      return tl::unexpected(std::move(fit).error());
    if (given.onlyResidue()) continue;  // the server's own, time and again
    stiffened_.erase(object);
    addWarnings(record, assets_.at(object));
  }
  for (const ObjectId object : stiffened_) {
    const ObjectRecord* const record = put(object);
    if (!record) continue;
    const ObjectAssets& assets = baseAssets_.at(object);
    if (auto fit = checkEffects(*record, *assets.mesh, ""); !fit) return tl::unexpected(std::move(fit).error());
    addWarnings(*record, assets);
  }
  std::ranges::move(overlaps(), std::back_inserter(reports));
  return reports;
}

/// What the edit puts into each other.
std::vector<std::string> SceneDraft::overlaps() const {
  const auto isPut = [&](const ObjectRecord& record) {
    const auto given = fieldPaths_.find(record.id);
    return posed_.contains(record.id) || (given != fieldPaths_.end() && !given->second.motion.empty());
  };
  std::vector<PlacedObject> objects;
  for (const ObjectRecord& record : changed_) {
    const auto own = assets_.find(record.id);
    objects.push_back({&record, own != assets_.end() ? &own->second : &baseAssets_.at(record.id), isPut(record)});
  }
  if (std::ranges::none_of(objects, &PlacedObject::isPut)) return {};
  for (const auto& object : base_.objects()) {
    const bool stays = !removed_.contains(object->id) && !std::ranges::count(changed_, object->id, &ObjectRecord::id);
    if (stays) objects.push_back({object.get(), &baseAssets_.at(object->id)});
  }
  return overlapWarnings(objects);
}

Result<std::string> SceneDraft::make(const PendingAsset& named, AssetResolver& resolver) {
  const auto mesh = meshOf(named);
  if (!mesh && std::holds_alternative<const GrownSource*>(named.source))
    return {};  // its object has been removed since
  struct Resolve {
    AssetResolver& resolver;
    const MeshAsset* mesh;
    double stiffness_N_per_m;
    auto operator()(const MeshSource* source) const { return resolver.resolve(*source, stiffness_N_per_m); }
    auto operator()(const MappedSource* source) const { return resolver.resolve(source->field); }
    auto operator()(const GrownSource* source) const { return resolver.resolve(source->points, *mesh); }
    auto operator()(const VertexValuesSource* source) const { return resolver.resolve(*source); }
    auto operator()(const ResidueSource* source) const { return resolver.resolve(*source); }
  };
  return std::visit(
      [&](const auto& source) -> Result<std::string> {
        const ObjectRecord* record = put(named.object);
        auto resolved =
            Resolve{resolver, mesh.get(), (record ? record->material : Material{}).stiffness_N_per_m}(source);
        if (!resolved) return tl::unexpected(std::move(resolved).error());
        if (auto room = checkRoom(*resolved->asset); !room) return tl::unexpected(std::move(room).error());
        const ContentHash& hash = resolved->asset->name.hash;
        made_[hash] = resolved->asset;
        setAssetHash(named, hash);
        return std::move(resolved->report);
      },
      named.source);
}

void SceneDraft::setAssetHash(const PendingAsset& named, const ContentHash& hash) {
  ObjectRecord* record = put(named.object);
  if (!record) return;
  if (named.place == Place::kMesh) record->mesh = hash;
  if (named.place == Place::kResidue) record->deformation.residue = hash;
  if (FieldFamily* family = fieldFamily(named)) {
    if (auto* mapped = std::get_if<MappedFamily>(family)) mapped->field = hash;
    if (auto* grown = std::get_if<GrownFamily>(family)) grown->points = hash;
  }
  if (!std::holds_alternative<const VertexValuesSource*>(named.source)) return;
  FactorMap* map = factorMap(named);
  if (auto* scale = map ? std::get_if<PerVertexScale>(map) : nullptr) scale->values = hash;
}

/// Against the assets of the scene as it was and those made so far: for a while, both are there.
Result<void> SceneDraft::checkRoom(const Asset& more) const {
  std::map<ContentHash, std::size_t> sizes{{more.name.hash, more.bytes().size()}};
  const auto add = [&](const auto& asset) { sizes[asset->name.hash] = asset->bytes().size(); };
  for (const auto& [hash, asset] : made_) add(asset);
  for (const auto& [object, its] : baseAssets_) {
    add(its.mesh);
    std::ranges::for_each(its.others, add);
  }
  std::size_t bytes = 0;
  for (const auto& [hash, size] : sizes) bytes += size;
  if (bytes <= limits_.assets_bytes) return {};
  return refused("source", "takes " + std::to_string(more.bytes().size()) + " bytes, which makes " +
                               std::to_string(bytes) + " with the scene's other assets; it holds at most " +
                               std::to_string(limits_.assets_bytes) + ": give less detail, or remove objects first");
}

Result<void> SceneDraft::checkDetailSizes() const {
  std::size_t bytes = 0;
  for (const auto& object : base_.objects()) {
    const bool stays = !removed_.contains(object->id) && !std::ranges::count(changed_, object->id, &ObjectRecord::id);
    if (stays) bytes += detailSizeOf(*object);
  }
  for (const ObjectRecord& record : changed_) bytes += detailSizeOf(record);
  if (bytes <= limits_.details_bytes) return {};
  const std::string why = "makes the Fourier terms, layers, creases, lattices and paths of all objects " +
                          std::to_string(bytes) + " bytes; a scene has at most " +
                          std::to_string(limits_.details_bytes);
  for (const auto& [object, given] : fieldPaths_) {
    if (!given.deformation.empty()) return refused(given.deformation + "lattice", why);
    if (given.surface.empty()) continue;
    const auto& [property, field] = *given.surface.begin();
    return refused(field + property, why);
  }
  if (!effectsGiven_.empty()) return refused(effectsGiven_.begin()->second, why);
  return {};
}

/// That the source is of; null for other sources.
FactorMap* SceneDraft::factorMap(const PendingAsset& named) {
  ObjectRecord* record = put(named.object);
  if (!record) return nullptr;
  SurfaceProperties& surface = record->material.surface;
  if (named.place == Place::kFriction && surface.friction) return &surface.friction->over;
  if (named.place == Place::kDynamicFriction && surface.friction) return &surface.friction->dynamicOver;
  if (named.place == Place::kStiffness && surface.stiffnessOver) return &surface.stiffnessOver->over;
  if (named.place == Place::kSoftness && surface.softnessOver) return &surface.softnessOver->over;
  return nullptr;
}

/// The record's family that the source is for: mapped or grown.
FieldFamily* SceneDraft::fieldFamily(const PendingAsset& named) {
  ObjectRecord* record = put(named.object);
  std::optional<std::size_t> layer;
  if (const auto* mapped = std::get_if<const MappedSource*>(&named.source)) {
    layer = (*mapped)->layer;
  } else if (const auto* grown = std::get_if<const GrownSource*>(&named.source)) {
    layer = (*grown)->layer;
  } else {
    return nullptr;
  }
  if (!record) return nullptr;
  FieldFamily* family = nullptr;
  auto& texture = record->material.surface.texture;
  if (named.place == Place::kTexture && texture) family = &texture->family;
  if (FactorMap* map = factorMap(named)) family = std::get_if<FieldFamily>(map);
  if (family && layer) family = &std::get<LayeredFamily>(*family).layers.at(*layer).family;
  return family;
}

void SceneDraft::fitMapping(const PendingAsset& named) {
  FieldFamily* family = fieldFamily(named);
  auto* mapped = family ? std::get_if<MappedFamily>(family) : nullptr;
  if (!mapped) return;
  if (const auto mesh = meshOf(named))
    fitToMesh(*std::get<const MappedSource*>(named.source), *mesh->mesh, mapped->mapping);
}

/// As it is made so far; null where the object is no more.
std::shared_ptr<const MeshAsset> SceneDraft::meshOf(const PendingAsset& named) {
  const ObjectRecord* record = put(named.object);
  return record ? as<MeshAsset>(findAsset(named.object, record->mesh)) : nullptr;
}

std::shared_ptr<const Asset> SceneDraft::findAsset(ObjectId object, const ContentHash& hash) const {
  if (const auto at = made_.find(hash); at != made_.end()) return at->second;
  const auto known = baseAssets_.find(object);
  return known == baseAssets_.end() ? nullptr : known->second.find(hash);
}

/// As it was prepared, and as it was.
std::vector<KnownObject> SceneDraft::known(const ObjectRecord& record, const AssetResolver& resolver) const {
  std::vector<KnownObject> known;
  if (const auto* prepared = resolver.prepared(record.name)) known.push_back({&prepared->record, &prepared->assets});
  if (const auto original = base_.find(record.id)) known.push_back({original.get(), &baseAssets_.at(record.id), true});
  return known;
}

Result<void> SceneDraft::gather(const ObjectRecord& record, const FieldPaths& given, AssetResolver& resolver) {
  const auto& shading = record.material.surface.shading;
  const bool creasesFit = std::ranges::any_of(known(record, resolver), [&](const KnownObject& its) {
    return its.record->mesh == record.mesh && its.record->material.surface.shading == shading;
  });
  if (const auto mesh = as<MeshAsset>(findAsset(record.id, record.mesh));
      mesh && shading && !shading->creases.empty() && !creasesFit) {
    if (auto may = resolver.beforeWork(mesh->mesh->triangles.size()); !may) return may;
  }
  const auto find = [&](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
    auto asset = findAsset(record.id, name.hash);
    if (!asset) return refused("", "is not here");
    return asset;
  };
  auto gathered = gatherAssets(record, find, creasesFit);
  if (gathered) {
    assets_[record.id] = *std::move(gathered);
    return {};
  }
  const auto& [field, reason] = gathered.error();
  if (const auto at = given.surface.find(field.substr(0, field.find('.'))); at != given.surface.end()) {
    return refused(at->second + field, reason);
  }
  if (field == "deformation.residue") return refused(given.residue, reason);
  return refused(given.mesh, "does not fit the object's " + field + ", which " + reason +
                                 "; edit that property in the same transaction, or take it away");
}

/// Refuses an effect inside of a mesh that is not closed.
/// @param remesh  Where the mesh was given; empty: it is as it was.
Result<void> SceneDraft::checkEffects(const ObjectRecord& record, const MeshAsset& mesh,
                                      const std::string& remesh) const {
  if (mesh.surface && mesh.surface->closed()) return {};
  const auto isInside = [](const Effect& effect) { return effect.region == Effect::Region::kInside; };
  const auto at = std::ranges::find_if(record.effects, isInside);
  if (at == record.effects.end()) return {};
  const std::string field = "[" + std::to_string(at - record.effects.begin()) + "].region";
  constexpr const char* kWhy =
      "is EFFECT_REGION_INSIDE, and the mesh is not closed; close its holes, or give a box or a sphere";
  if (const auto given = effectsGiven_.find(record.id); given != effectsGiven_.end())
    return refused(given->second + field, kWhy);
  return refused(remesh, "does not fit the object's effects" + field + ", which " + kWhy);
}

/// Checks the motion with the mesh that the object has after the transaction.
Result<void> SceneDraft::checkMotion(const ObjectRecord& record, const FieldPaths& given) const {
  if (!record.motion) return {};
  const bool byMotion = !given.motion.empty();
  if (byMotion) {
    if (auto fits = checkMovingCount(given.motion); !fits) return fits;
  }
  const auto body = bodyPartsOf(record, assets_.at(record.id));
  if (*body) return {};
  const auto& [field, reason] = body->error();
  if (byMotion) return refused(given.motion + field, reason);
  return refused(given.mesh, "does not fit the object's motion." + field + ", which " + reason);
}

Result<void> SceneDraft::checkMovingCount(const std::string& field) const {
  std::size_t count = 0;
  forEachRecord([&](const ObjectRecord& record) { count += record.movesByItself() ? 1 : 0; });
  if (count <= kMaxMovingBodies) return {};
  return refused(field.substr(0, field.size() - 1), "makes " + std::to_string(count) + " objects move; at most " +
                                                        std::to_string(kMaxMovingBodies) + " of a scene may");
}

/// To the mesh that the object has after the transaction.
Result<void> SceneDraft::fitDeformation(ObjectRecord& record, const FieldPaths& given) const {
  auto unfit = fitToMesh(record.deformation, *assets_.at(record.id).mesh->mesh, given.latticeOfMesh);
  if (!unfit) return {};
  const auto& [field, reason] = *unfit;
  if (!given.deformation.empty()) return refused(given.deformation + field, reason);
  return refused(given.mesh, "does not fit the object's deformation." + field + ", which " + reason);
}

}  // namespace haptics
