#include "haptic_server/scene/scene_draft.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

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

SceneDraft::SceneDraft(const SceneVersion& base, ObjectId nextId) : base_(base), nextId_(nextId) {}

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
  named_.push_back({field + "add.mesh.", record.id, record.name, &add.mesh});
  put_.push_back(std::move(record));
  return {};
}

Result<void> SceneDraft::apply(const RemoveObject& remove, const std::string& field) {
  const auto record = edit(remove.object, field + "remove.object");
  if (!record) return tl::unexpected(record.error());
  const ObjectId id = (*record)->id;
  if (base_.find(id)) removed_.insert(id);
  std::erase_if(put_, [id](const ObjectRecord& r) { return r.id == id; });
  return {};
}

Result<void> SceneDraft::apply(const RemeshObject& remesh, const std::string& field) {
  const auto record = edit(remesh.object, field + "remesh.object");
  if (!record) return tl::unexpected(record.error());
  named_.push_back({field + "remesh.mesh.", (*record)->id, (*record)->name, &remesh.mesh});
  return {};
}

Result<void> SceneDraft::apply(const SetPose& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_pose.object");
  if (!record) return tl::unexpected(record.error());
  (*record)->pose = edited((*record)->pose, set.pose);
  return {};
}

Result<void> SceneDraft::apply(const SetMaterial& set, const std::string& field) {
  const auto record = edit(set.object, field + "set_material.object");
  if (!record) return tl::unexpected(record.error());
  (*record)->material = edited((*record)->material, set.material);
  return {};
}

Result<std::vector<std::string>> SceneDraft::resolveMeshes(MeshResolver& resolver) {
  std::vector<std::string> reports;
  for (const NamedMesh& named : named_) {
    auto resolved = resolver.resolve(*named.source);
    if (!resolved) return tl::unexpected(std::move(resolved).error().within(named.field));
    reports.push_back(named.name + ": " + resolved->report);
    if (ObjectRecord* record = put(named.object)) {
      record->mesh = resolved->asset->hash;
      meshes_[named.object] = std::move(resolved->asset);
    }
  }
  return reports;
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
