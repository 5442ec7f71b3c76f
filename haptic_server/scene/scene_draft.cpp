#include "haptic_server/scene/scene_draft.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "haptic_server/scene/fit_deformation.h"
#include "haptic_server/scene/fit_mapping.h"
#include "haptic_server/servo/servo_scene.h"

namespace haptics {
namespace {

constexpr std::size_t kMaxName = 64;       // characters; as scene.proto promises
constexpr std::size_t kNamesInError = 16;  // enough to see a slip of the pen, short enough to read

bool isWellFormed(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  return !name.empty() && name.size() <= kMaxName && std::ranges::all_of(name, allowed);
}

std::string listed(const std::vector<std::string>& names) {
  if (names.empty()) return "the scene is empty";
  std::string text = "there are ";
  for (std::size_t i = 0; i < std::min(names.size(), kNamesInError); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kNamesInError) text += " and " + std::to_string(names.size() - kNamesInError) + " more";
  return text;
}

}  // namespace

SceneDraft::SceneDraft(const SceneVersion& base, const Assets& baseAssets, ObjectId nextId, const SceneLimits& limits)
    : base_(base), baseAssets_(baseAssets), nextId_(nextId), limits_(limits) {}

Result<void> SceneDraft::apply(const Operation& operation, const std::string& field) {
  return std::visit([&](const auto& op) { return apply(op, field); }, operation);
}

Result<void> SceneDraft::apply(const AddObject& add, const std::string& field) {
  if (!isWellFormed(add.name)) {
    return refused(field + "add.name", "must be 1 to 64 characters of A-Z a-z 0-9 _ - .");
  }
  if (find(ObjectRef{add.name})) {
    return refused(field + "add.name", "there is an object \"" + add.name + "\" already; names are unique");
  }
  if (names().size() >= kMaxServoObjects) {
    return refused(field + "add",
                   "the scene holds " + std::to_string(kMaxServoObjects) + " objects, which is the most");
  }
  ObjectRecord record;
  record.id = nextId_++;
  record.name = add.name;
  record.revision = base_.revision() + 1;
  record.pose = edited(record.pose, add.pose);
  record.material = edited(record.material, add.material);
  named_.push_back({field + "add.mesh.", record.id, record.name, Place::kMesh, &add.mesh});
  given_[record.id].mesh = field + "add.mesh";
  apply(add.material.surface, field + "add.material.", record);
  record.motion = add.motion;
  if (add.motion) given_[record.id].motion = field + "add.motion.";
  apply(add.deformation, field + "add.deformation.", record);
  put_.push_back(std::move(record));
  return {};
}

Result<void> SceneDraft::apply(const RemoveObject& remove, const std::string& field) {
  const auto record = edit(remove.object, field + "remove.object");
  if (!record) return tl::unexpected(record.error());
  const ObjectId id = (*record)->id;
  if (base_.find(id)) removed_.insert(id);
  std::erase_if(put_, [id](const ObjectRecord& r) { return r.id == id; });
  given_.erase(id);
  return {};
}

Result<void> SceneDraft::apply(const RemeshObject& remesh, const std::string& field) {
  const auto record = edit(remesh.object, field + "remesh.object");
  if (!record) return tl::unexpected(record.error());
  const ObjectId id = (*record)->id;
  named_.push_back({field + "remesh.mesh.", id, (*record)->name, Place::kMesh, &remesh.mesh});
  given_[id].mesh = field + "remesh.mesh";
  dropResidue(**record);
  return {};
}

Result<void> SceneDraft::apply(const SetPose& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_pose.object");
  if (!record) return tl::unexpected(record.error());
  (*record)->pose = edited((*record)->pose, set.pose);
  posed_.insert((*record)->id);
  return {};
}

Result<void> SceneDraft::apply(const SetMaterial& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_material.object");
  if (!record) return tl::unexpected(record.error());
  (*record)->material = edited((*record)->material, set.material);
  if (set.material.stiffness_N_per_m || set.material.damping_Ns_per_m) stiffened_.insert((*record)->id);
  apply(set.material.surface, field + "set_material.material.", **record);
  return {};
}

Result<void> SceneDraft::apply(const SetMotion& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_motion.object");
  if (!record) return tl::unexpected(record.error());
  (*record)->motion = set.motion;
  given_[(*record)->id].motion = set.motion ? field + "set_motion.motion." : "";
  return {};
}

Result<void> SceneDraft::apply(const SetDeformation& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_deformation.object");
  if (!record) return tl::unexpected(record.error());
  apply(set.deformation, field + "set_deformation.deformation.", **record);
  return {};
}

void SceneDraft::apply(const DeformationEdit& edit, const std::string& field, ObjectRecord& record) {
  if (edit.empty()) return;
  if (edit.lattice || edit.residue) dropResidue(record);
  record.deformation = edited(std::move(record.deformation), edit);
  Given& given = given_[record.id];
  if (edit.softness || edit.lattice) given.deformation = field;
  if (edit.lattice) given.latticeOfMesh = edit.latticeOfMesh;
  if (!edit.residue || !*edit.residue) return;
  given.residue = field + "residue";
  named_.push_back({given.residue + ".", record.id, record.name, Place::kResidue, ResidueSource{**edit.residue}});
}

/// Of another mesh or lattice, or overruled by a later operation.
void SceneDraft::dropResidue(ObjectRecord& record) {
  record.deformation.residue.reset();
  std::erase_if(named_,
                [&](const Named& named) { return named.object == record.id && named.place == Place::kResidue; });
}

void SceneDraft::apply(const SurfaceEdit& edit, const std::string& field, const ObjectRecord& record) {
  if (edit.empty()) return;
  auto& surface = given_[record.id].surface;
  if (edit.shading) surface["shading"] = field;
  if (edit.friction) surface["friction"] = field;
  if (edit.texture) surface["texture"] = field;
  if (edit.stiffnessOver) surface["stiffness_over"] = field;
  if (edit.softnessOver) surface["softness_over"] = field;
  // What an earlier operation of the transaction gave is overruled.
  std::erase_if(named_, [&](const Named& named) {
    const bool ofFriction = named.place == Place::kFriction || named.place == Place::kDynamicFriction;
    const bool overruled = (ofFriction && edit.friction) || (named.place == Place::kTexture && edit.texture) ||
                           (named.place == Place::kStiffness && edit.stiffnessOver) ||
                           (named.place == Place::kSoftness && edit.softnessOver);
    return named.object == record.id && overruled;
  });
  const auto name = [&](const std::string& below, Place place, auto* source) {
    named_.push_back({field + below, record.id, record.name, place, source});
  };
  const auto nameFields = [&](const std::string& below, Place place, const std::vector<FamilySource>& sources) {
    for (const FamilySource& source : sources) {
      std::visit([&](const auto& chosen) { name(below + fieldName(source) + ".", place, &chosen); }, source);
    }
  };
  const auto nameMap = [&](const std::string& prefix, Place place, const FactorMapSource& source) {
    if (const auto* of = std::get_if<std::vector<FamilySource>>(&source)) nameFields(prefix + "field.", place, *of);
    if (const auto* of = std::get_if<VertexValuesSource>(&source)) name(prefix + "per_vertex.", place, of);
  };
  if (edit.friction && *edit.friction) {
    nameMap("friction.", Place::kFriction, (*edit.friction)->source);
    nameMap("friction.dynamic_", Place::kDynamicFriction, (*edit.friction)->dynamicSource);
  }
  if (edit.texture && *edit.texture) nameFields("texture.field.", Place::kTexture, (*edit.texture)->sources);
  if (edit.stiffnessOver && *edit.stiffnessOver) {
    nameMap("stiffness_over.", Place::kStiffness, (*edit.stiffnessOver)->source);
  }
  if (edit.softnessOver && *edit.softnessOver) {
    nameMap("softness_over.", Place::kSoftness, (*edit.softnessOver)->source);
  }
}

Result<std::vector<std::string>> SceneDraft::resolve(AssetResolver& resolver) {
  constexpr std::array<const char*, 7> kOf{"",           "friction: ", "dynamic friction: ", "texture: ", "stiffness: ",
                                           "softness: ", "residue: "};  // as Place counts
  std::vector<std::string> reports;
  // What grows on a mesh comes after all meshes.
  std::stable_partition(named_.begin(), named_.end(),
                        [](const Named& named) { return !std::holds_alternative<const GrownSource*>(named.source); });
  for (const Named& named : named_) {
    auto report = make(named, resolver);
    if (!report) return tl::unexpected(std::move(report).error().within(named.field));
    if (!report->empty()) reports.push_back(named.name + ": " + kOf[static_cast<std::size_t>(named.place)] + *report);
  }
  if (auto fits = checkDetails(); !fits) return tl::unexpected(std::move(fits).error());
  for (const Named& named : named_) fitMapping(named);
  const auto addRemarks = [&](const ObjectRecord& record, const ObjectAssets& assets) {
    for (const std::string& remark : resolver.remarks(record, assets)) reports.push_back(record.name + ": " + remark);
  };
  for (const auto& [object, given] : given_) {
    ObjectRecord& record = *put(object);
    if (auto gathered = gather(record, given, resolver); !gathered) return tl::unexpected(std::move(gathered).error());
    if (auto fits = fitDeformation(record, given); !fits) return tl::unexpected(std::move(fits).error());
    derive(record, assets_.at(object), known(record, resolver), !(given.mesh.empty() && given.deformation.empty()),
           [&resolver](std::size_t triangles) { resolver.beforeWork(triangles); });
    if (auto moves = checkMotion(record, given); !moves) return tl::unexpected(std::move(moves).error());
    if (given.onlyResidue()) continue;  // the server's own, time and again
    stiffened_.erase(object);
    addRemarks(record, assets_.at(object));
  }
  for (const ObjectId object : stiffened_) {
    if (const ObjectRecord* record = put(object)) addRemarks(*record, baseAssets_.at(object));
  }
  return reports;
}

Result<std::string> SceneDraft::make(const Named& named, AssetResolver& resolver) {
  const auto mesh = meshOf(named);
  if (!mesh && std::holds_alternative<const GrownSource*>(named.source))
    return {};  // its object has been removed since
  struct Resolve {
    AssetResolver& resolver;
    const MeshAsset* mesh;
    auto operator()(const MeshSource* source) const { return resolver.resolve(*source); }
    auto operator()(const MappedSource* source) const { return resolver.resolve(source->field); }
    auto operator()(const GrownSource* source) const { return resolver.resolve(source->points, *mesh); }
    auto operator()(const VertexValuesSource* source) const { return resolver.resolve(*source); }
    auto operator()(const ResidueSource& source) const { return resolver.resolve(source); }
  };
  return std::visit(
      [&](const auto& source) -> Result<std::string> {
        auto resolved = Resolve{resolver, mesh.get()}(source);
        if (!resolved) return tl::unexpected(std::move(resolved).error());
        if (auto room = checkRoom(*resolved->asset); !room) return tl::unexpected(std::move(room).error());
        const ContentHash& hash = resolved->asset->name.hash;
        made_[hash] = resolved->asset;
        enter(named, hash);
        return std::move(resolved->report);
      },
      named.source);
}

void SceneDraft::enter(const Named& named, const ContentHash& hash) {
  ObjectRecord* record = put(named.object);
  if (!record) return;
  if (named.place == Place::kMesh) record->mesh = hash;
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

Result<void> SceneDraft::checkDetails() const {
  std::size_t bytes = 0;
  for (const auto& object : base_.objects()) {
    const bool stays = !removed_.contains(object->id) && !std::ranges::count(put_, object->id, &ObjectRecord::id);
    if (stays) bytes += detailSizeOf(*object);
  }
  for (const ObjectRecord& record : put_) bytes += detailSizeOf(record);
  if (bytes <= limits_.details_bytes) return {};
  const std::string why = "makes the Fourier terms, layers, creases and lattices of all objects " +
                          std::to_string(bytes) + " bytes; a scene has at most " +
                          std::to_string(limits_.details_bytes);
  for (const auto& [object, given] : given_) {
    if (!given.deformation.empty()) return refused(given.deformation + "lattice", why);
    if (given.surface.empty()) continue;
    const auto& [property, field] = *given.surface.begin();
    return refused(field + property, why);
  }
  return {};
}

/// That the source is of; null for other sources.
FactorMap* SceneDraft::factorMap(const Named& named) {
  ObjectRecord* record = put(named.object);
  if (!record) return nullptr;
  SurfaceProperties& surface = record->material.surface;
  if (named.place == Place::kFriction && surface.friction) return &surface.friction->over;
  if (named.place == Place::kDynamicFriction && surface.friction) return &surface.friction->dynamicOver;
  if (named.place == Place::kStiffness && surface.stiffnessOver) return &surface.stiffnessOver->over;
  if (named.place == Place::kSoftness && surface.softnessOver) return &surface.softnessOver->over;
  return nullptr;
}

/// Likewise: mapped or grown.
FieldFamily* SceneDraft::fieldFamily(const Named& named) {
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

void SceneDraft::fitMapping(const Named& named) {
  FieldFamily* family = fieldFamily(named);
  auto* mapped = family ? std::get_if<MappedFamily>(family) : nullptr;
  if (!mapped) return;
  if (const auto mesh = meshOf(named))
    fitToMesh(*std::get<const MappedSource*>(named.source), *mesh->mesh, mapped->mapping);
}

/// As it is made so far; null where the object is no more.
std::shared_ptr<const MeshAsset> SceneDraft::meshOf(const Named& named) {
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

Result<void> SceneDraft::gather(const ObjectRecord& record, const Given& given, const AssetResolver& resolver) {
  const auto& shading = record.material.surface.shading;
  const bool creasesFit = std::ranges::any_of(known(record, resolver), [&](const KnownObject& its) {
    return its.record->mesh == record.mesh && its.record->material.surface.shading == shading;
  });
  if (const auto mesh = as<MeshAsset>(findAsset(record.id, record.mesh)); mesh && shading && !creasesFit) {
    if (!shading->creases.empty()) resolver.beforeWork(mesh->mesh->triangles.size());
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

/// Of the mesh that the object has after the transaction.
Result<void> SceneDraft::checkMotion(const ObjectRecord& record, const Given& given) const {
  if (!record.motion) return {};
  const bool byMotion = !given.motion.empty();
  if (byMotion) {
    if (auto fits = checkMovingCount(given.motion); !fits) return fits;
  }
  const auto body = feltBodyOf(record, assets_.at(record.id));
  if (*body) return {};
  const auto& [field, reason] = body->error();
  if (byMotion) return refused(given.motion + field, reason);
  return refused(given.mesh, "does not fit the object's motion." + field + ", which " + reason);
}

Result<void> SceneDraft::checkMovingCount(const std::string& field) const {
  std::size_t count = 0;
  for (const auto& object : base_.objects()) {
    const bool stays = !removed_.contains(object->id) && !std::ranges::count(put_, object->id, &ObjectRecord::id);
    if (stays && object->motion) ++count;
  }
  for (const ObjectRecord& record : put_) count += record.motion ? 1 : 0;
  if (count <= kMaxMovingBodies) return {};
  return refused(field.substr(0, field.size() - 1), "makes " + std::to_string(count) + " objects move; at most " +
                                                        std::to_string(kMaxMovingBodies) + " of a scene may");
}

/// To the mesh that the object has after the transaction.
Result<void> SceneDraft::fitDeformation(ObjectRecord& record, const Given& given) const {
  auto unfit = fitToMesh(record.deformation, *assets_.at(record.id).mesh->mesh, given.latticeOfMesh);
  if (!unfit) return {};
  const auto& [field, reason] = *unfit;
  if (!given.deformation.empty()) return refused(given.deformation + field, reason);
  return refused(given.mesh, "does not fit the object's deformation." + field + ", which " + reason);
}

Commit SceneDraft::commit() const {
  return {.revision = base_.revision() + 1,
          .prevRoot = base_.root(),
          .put = put_,
          .removed = {removed_.begin(), removed_.end()},
          .root = {}};
}

const ObjectRecord* SceneDraft::find(const ObjectRef& ref) const {
  const auto* id = std::get_if<ObjectId>(&ref.value);
  const auto* name = std::get_if<std::string>(&ref.value);
  for (const ObjectRecord& record : put_) {
    if (id ? record.id == *id : record.name == *name) return &record;
  }
  const auto original = id ? base_.find(*id) : base_.find(*name);
  return original && !removed_.contains(original->id) ? original.get() : nullptr;
}

Result<ObjectRecord*> SceneDraft::edit(const ObjectRef& ref, const std::string& field) {
  const ObjectRecord* record = find(ref);
  if (!record) return refused(field, "there is no " + ref.text() + "; " + listed(names()));
  if (ObjectRecord* known = put(record->id)) return known;
  put_.push_back(*record);
  put_.back().revision = base_.revision() + 1;
  return &put_.back();
}

ObjectRecord* SceneDraft::put(ObjectId id) {
  const auto at = std::ranges::find(put_, id, &ObjectRecord::id);
  return at == put_.end() ? nullptr : &*at;
}

std::vector<std::string> SceneDraft::names() const {
  std::vector<std::string> names;
  for (const auto& object : base_.objects()) {
    if (!removed_.contains(object->id)) names.push_back(object->name);
  }
  for (const ObjectRecord& record : put_) {
    if (!base_.find(record.id)) names.push_back(record.name);
  }
  return names;
}

}  // namespace haptics
