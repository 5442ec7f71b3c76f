#include "haptic_server/scene/scene_draft.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {
namespace {

constexpr std::size_t kMaxName = 64;       // characters; as scene.proto promises
constexpr std::size_t kNamesInError = 16;  // enough to see a slip of the pen, short enough to read

/// Of the paths of all effects of a scene. Where they lie on a sphere round the HIP, a tick looks at each: 12 ns.
constexpr std::size_t kMaxPathPointsOfAll = 2 * kMaxPathPoints;

std::size_t pointsOf(const std::vector<Effect>& effects) {
  std::size_t points = 0;
  for (const Effect& effect : effects) points += effect.path_m.size();
  return points;
}

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
  ++operations_;
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
  pendingAssets_.push_back({field + "add.mesh.", record.id, record.name, Place::kMesh, &add.mesh});
  fieldPaths_[record.id].mesh = field + "add.mesh";
  apply(add.material.surface, field + "add.material.", record);
  record.motion = add.motion;
  if (add.motion) fieldPaths_[record.id].motion = field + "add.motion.";
  apply(add.deformation, field + "add.deformation.", record);
  if (auto set = setEffects(add.effects, field + "add.effects", record); !set) return set;
  changed_.push_back(std::move(record));
  return {};
}

Result<void> SceneDraft::apply(const RemoveObject& remove, const std::string& field) {
  const auto record = edit(remove.object, field + "remove.object");
  if (!record) return tl::unexpected(record.error());
  const ObjectId id = (*record)->id;
  if (base_.find(id)) removed_.insert(id);
  std::erase_if(changed_, [id](const ObjectRecord& r) { return r.id == id; });
  fieldPaths_.erase(id);
  return {};
}

Result<void> SceneDraft::apply(const RemeshObject& remesh, const std::string& field) {
  const auto record = edit(remesh.object, field + "remesh.object");
  if (!record) return tl::unexpected(record.error());
  const ObjectId id = (*record)->id;
  pendingAssets_.push_back({field + "remesh.mesh.", id, (*record)->name, Place::kMesh, &remesh.mesh});
  fieldPaths_[id].mesh = field + "remesh.mesh";
  reshaped_.insert(id);
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
  fieldPaths_[(*record)->id].motion = field + "set_motion.motion.";
  return {};
}

Result<void> SceneDraft::apply(const SetDeformation& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_deformation.object");
  if (!record) return tl::unexpected(record.error());
  apply(set.deformation, field + "set_deformation.deformation.", **record);
  return {};
}

Result<void> SceneDraft::apply(const SetEffects& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_effects.object");
  if (!record) return tl::unexpected(record.error());
  return setEffects(set.effects, field + "set_effects.effects", **record);
}

Result<void> SceneDraft::setEffects(const std::vector<Effect>& effects, const std::string& field,
                                    ObjectRecord& record) {
  record.effects = effects;
  effectsGiven_.erase(record.id);
  if (effects.empty()) return {};
  effectsGiven_[record.id] = field;
  stiffened_.insert(record.id);
  std::size_t count = 0, points = 0;
  forEachRecord([&](const ObjectRecord& other) {
    if (other.id == record.id) return;
    count += other.effects.size();
    points += pointsOf(other.effects);
  });
  if (effects.size() + count > kMaxEffects) {
    return refused(field, "has " + std::to_string(effects.size()) + " entries, and other objects have " +
                              std::to_string(count) + "; a scene has at most " + std::to_string(kMaxEffects));
  }
  const std::size_t own = pointsOf(effects);
  if (own == 0 || own + points <= kMaxPathPointsOfAll) return {};
  return refused(field, "has paths of " + std::to_string(own) + " points, and other objects of " +
                            std::to_string(points) + "; those of a scene have at most " +
                            std::to_string(kMaxPathPointsOfAll) +
                            ": leave out those that lie nearly on a line with their neighbours");
}

void SceneDraft::apply(const DeformationEdit& edit, const std::string& field, ObjectRecord& record) {
  if (edit.empty()) return;
  if (edit.lattice || edit.residue) {
    dropResidue(record);
    reshaped_.insert(record.id);
  }
  record.deformation = edited(std::move(record.deformation), edit);
  FieldPaths& given = fieldPaths_[record.id];
  if (edit.softness || edit.lattice) given.deformation = field;
  if (edit.lattice) given.latticeOfMesh = edit.latticeOfMesh;
  if (!edit.residue || !*edit.residue) return;
  given.residue = field + "residue";
  pendingAssets_.push_back({given.residue + ".", record.id, record.name, Place::kResidue, &**edit.residue});
}

/// Drops a residue of another mesh or lattice, or one that a later operation overrules.
void SceneDraft::dropResidue(ObjectRecord& record) {
  record.deformation.residue.reset();
  std::erase_if(pendingAssets_,
                [&](const PendingAsset& named) { return named.object == record.id && named.place == Place::kResidue; });
}

void SceneDraft::apply(const SurfaceEdit& edit, const std::string& field, const ObjectRecord& record) {
  if (edit.empty()) return;
  auto& surface = fieldPaths_[record.id].surface;
  if (edit.shading) surface["shading"] = field;
  if (edit.friction) surface["friction"] = field;
  if (edit.texture) surface["texture"] = field;
  if (edit.stiffnessOver) surface["stiffness_over"] = field;
  if (edit.softnessOver) surface["softness_over"] = field;
  // What an earlier operation of the transaction gave is overruled.
  std::erase_if(pendingAssets_, [&](const PendingAsset& named) {
    const bool ofFriction = named.place == Place::kFriction || named.place == Place::kDynamicFriction;
    const bool overruled = (ofFriction && edit.friction) || (named.place == Place::kTexture && edit.texture) ||
                           (named.place == Place::kStiffness && edit.stiffnessOver) ||
                           (named.place == Place::kSoftness && edit.softnessOver);
    return named.object == record.id && overruled;
  });
  const auto name = [&](const std::string& below, Place place, auto* source) {
    pendingAssets_.push_back({field + below, record.id, record.name, place, source});
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

Commit SceneDraft::commit() const {
  return {.revision = base_.revision() + 1,
          .prevRoot = base_.root(),
          .put = changed_,
          .removed = {removed_.begin(), removed_.end()},
          .root = {}};
}

const ObjectRecord* SceneDraft::find(const ObjectRef& ref) const {
  const auto* id = std::get_if<ObjectId>(&ref.value);
  const auto* name = std::get_if<std::string>(&ref.value);
  for (const ObjectRecord& record : changed_) {
    if (id ? record.id == *id : record.name == *name) return &record;
  }
  const auto original = id ? base_.find(*id) : base_.find(*name);
  return original && !removed_.contains(original->id) ? original.get() : nullptr;
}

Result<ObjectRecord*> SceneDraft::edit(const ObjectRef& ref, const std::string& field) {
  const ObjectRecord* record = find(ref);
  if (!record) return refused(field, "there is no " + ref.text() + "; " + listed(names()));
  if (ObjectRecord* known = put(record->id)) return known;
  changed_.push_back(*record);
  changed_.back().revision = base_.revision() + 1;
  return &changed_.back();
}

ObjectRecord* SceneDraft::put(ObjectId id) {
  const auto at = std::ranges::find(changed_, id, &ObjectRecord::id);
  return at == changed_.end() ? nullptr : &*at;
}

std::vector<std::string> SceneDraft::names() const {
  std::vector<std::string> names;
  for (const auto& object : base_.objects()) {
    if (!removed_.contains(object->id)) names.push_back(object->name);
  }
  for (const ObjectRecord& record : changed_) {
    if (!base_.find(record.id)) names.push_back(record.name);
  }
  return names;
}

}  // namespace haptics
