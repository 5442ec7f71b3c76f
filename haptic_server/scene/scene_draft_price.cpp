// What it takes to make what a draft's operations name.
#include <algorithm>
#include <map>
#include <utility>
#include <variant>

#include "common/surface/makers/even_samples.h"
#include "haptic_server/scene/edit_price.h"
#include "haptic_server/scene/mesh_library.h"
#include "haptic_server/scene/scene_draft.h"

namespace haptics {

Result<void> SceneDraft::checkPrice(AssetResolver& resolver) const { return haptics::checkPrice(priceOf(resolver)); }

Price SceneDraft::priceOf(AssetResolver& resolver) const {
  const std::size_t objects = base_.objects().size() + changed_.size();
  Price price = priceOfDeciding(operations_, objects);
  std::map<ObjectId, PricedMesh> meshes;
  for (const auto& [object, assets] : baseAssets_) meshes[object] = {assets.mesh, std::nullopt};
  for (const PendingAsset& named : pendingAssets_) {
    if (named.place != Place::kMesh) continue;
    price += priceOfMesh(named, meshes[named.object] = pricedMesh(named, resolver));
  }
  for (const PendingAsset& named : pendingAssets_) price += priceOfField(named, meshes[named.object]);
  for (const ObjectRecord& record : changed_) {
    const auto& texture = record.material.surface.texture;
    const auto given = fieldPaths_.find(record.id);
    if (texture && (given != fieldPaths_.end() || stiffened_.contains(record.id))) price += haptics::priceOf(*texture);
    const bool newBody = given != fieldPaths_.end() && !(given->second.mesh.empty() && given->second.motion.empty());
    if (newBody || effectsGiven_.contains(record.id)) price += haptics::priceOf(record.effects);
    if (given != fieldPaths_.end()) price += priceOfParts(record, given->second, meshes[record.id]);
  }
  return price += priceOfSharpPoints(meshes);
}

SceneDraft::PricedMesh SceneDraft::pricedMesh(const PendingAsset& named, AssetResolver& resolver) const {
  const MeshSource& source = *std::get<const MeshSource*>(named.source);
  if (auto recipe = recipeOf(source)) return {nullptr, std::move(recipe)};
  if (std::holds_alternative<AssetSource>(source.source)) {
    auto here = resolver.resolve(MeshSource{source.source}, 0);
    return {here ? std::move(here->asset) : nullptr, std::nullopt};
  }
  const ObjectRecord* record = changed(named.object);
  const auto made = record ? made_.find(record->mesh) : made_.end();
  return {made == made_.end() ? nullptr : as<MeshAsset>(made->second), std::nullopt};
}

MeshNumbers SceneDraft::numbersOf(const PricedMesh& mesh) {
  if (mesh.asset) return haptics::numbersOf(*mesh.asset);
  return mesh.recipe ? haptics::numbersOf(*mesh.recipe) : MeshNumbers{};
}

double SceneDraft::areaOf_m2(const PricedMesh& mesh) {
  if (mesh.asset) return haptics::areaOf_m2(*mesh.asset->mesh);
  return mesh.recipe ? haptics::areaOf_m2(*mesh.recipe) : 0;
}

Price SceneDraft::priceOfMesh(const PendingAsset& named, const PricedMesh& mesh) const {
  const MeshNumbers numbers = numbersOf(mesh);
  Price price;
  if (mesh.recipe) price += haptics::priceOfMesh(numbers);
  const ObjectRecord* record = changed(named.object);
  if (std::get<const MeshSource*>(named.source)->simplifyError && numbers.triangles > 0)
    price += priceOfSimplifying(numbers, (record ? record->material : Material{}).stiffness_N_per_m);
  return price;
}

/// None: it is no field that is computed.
Price SceneDraft::priceOfField(const PendingAsset& named, const PricedMesh& mesh) {
  if (const auto* mapped = std::get_if<const MappedSource*>(&named.source)) return haptics::priceOf((*mapped)->field);
  const auto* grown = std::get_if<const GrownSource*>(&named.source);
  const auto* source = grown ? std::get_if<GrownReactionDiffusionSource>(&(*grown)->points) : nullptr;
  if (source == nullptr || !(mesh.asset || mesh.recipe)) return {};
  return priceOfGrowing(*source, numbersOf(mesh), areaOf_m2(mesh));
}

/// Derived parts of an object that the operations gave these of.
Price SceneDraft::priceOfParts(const ObjectRecord& record, const FieldPaths& given, const PricedMesh& priced) {
  const MeshNumbers mesh = numbersOf(priced);
  const DeformationProperties& deformation = record.deformation;
  const bool newShape = !(given.mesh.empty() && given.deformation.empty() && given.residue.empty());
  Price price = priceOfLooking(mesh);
  if (newShape && (deformation.lattice || deformation.residue)) price += priceOfShape(mesh, deformation);
  if (record.motion && !(given.mesh.empty() && given.motion.empty())) {
    price += priceOfBody(mesh, *record.motion);
    if (record.motion->tool) price += priceOfTool(mesh, areaOf_m2(priced), record.motion->tool->spacing_m);
  }
  const auto& shading = record.material.surface.shading;
  if (shading && (newShape || given.surface.contains("shading")))
    price += priceOfShading(mesh, shading->creases.size());
  return price;
}

/// For a tool, of all that it may touch: of what is new to it.
Price SceneDraft::priceOfSharpPoints(const std::map<ObjectId, PricedMesh>& meshes) const {
  const auto holds = [](const ObjectRecord& record) { return record.motion && record.motion->tool; };
  const auto isNew = [&](const ObjectRecord& record) {
    const auto given = fieldPaths_.find(record.id);
    return given != fieldPaths_.end() && !(given->second.mesh.empty() && given->second.motion.empty());
  };
  const bool newTool =
      std::ranges::any_of(changed_, [&](const auto& record) { return holds(record) && isNew(record); });
  const bool anyTool = newTool || std::ranges::any_of(base_.objects(), [&](const auto& o) { return holds(*o); });
  Price price;
  if (!anyTool) return price;
  for (const auto& [object, mesh] : meshes) {
    if (newTool || fieldPaths_.contains(object)) price += haptics::priceOfSharpPoints(numbersOf(mesh));
  }
  return price;
}

const ObjectRecord* SceneDraft::changed(ObjectId id) const {
  const auto at = std::ranges::find(changed_, id, &ObjectRecord::id);
  return at == changed_.end() ? nullptr : &*at;
}

}  // namespace haptics
