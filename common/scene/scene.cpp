#include "common/scene/scene.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace haptics {

Operation::Operation() noexcept = default;
Operation::Operation(const Operation&) = default;
Operation::Operation(Operation&&) noexcept = default;
Operation& Operation::operator=(const Operation&) = default;
Operation& Operation::operator=(Operation&&) noexcept = default;
Operation::~Operation() = default;

/// Before the motion in an object's hash, after the properties of its surface, which have lower numbers.
constexpr std::uint64_t kMotion = 4;

ContentHash ObjectRecord::hash() const {
  Hasher h;
  h.add(id).add(std::string_view(name)).add(revision).add(mesh);
  h.add(pose.rotation.w).add(pose.rotation.x).add(pose.rotation.y).add(pose.rotation.z);
  h.add(pose.position.x).add(pose.position.y).add(pose.position.z);
  h.add(material.stiffness_N_per_m).add(material.damping_Ns_per_m);
  h.add(material.color.red).add(material.color.green).add(material.color.blue);
  addTo(h, material.surface);
  if (motion) {
    h.add(kMotion);
    addTo(h, *motion);
  }
  addTo(h, deformation);
  addTo(h, effects);
  return h.finish();
}

std::vector<AssetName> ObjectRecord::assets() const {
  std::vector<AssetName> names = assetsOf(material.surface);
  names.insert(names.begin(), {AssetKind::kMesh, mesh});
  if (deformation.residue) names.push_back({AssetKind::kMovedVertices, *deformation.residue});
  return names;
}

SceneVersion::SceneVersion() { updateRoot(); }

Result<SceneVersion> SceneVersion::fromSnapshot(std::uint64_t revision, std::vector<ObjectRecord> objects) {
  std::ranges::sort(objects, {}, &ObjectRecord::id);
  SceneVersion version;
  version.revision_ = revision;
  std::unordered_set<std::string> names;
  ObjectId last = 0;
  for (ObjectRecord& record : objects) {
    if (record.id == last) return refused("object", "id " + std::to_string(last) + " is zero or given twice");
    if (record.name.empty() || !names.insert(record.name).second) {
      return refused("object", "name \"" + record.name + "\" is empty or given twice");
    }
    last = record.id;
    version.hashes_.push_back(record.hash());
    version.objects_.push_back(std::make_shared<const ObjectRecord>(std::move(record)));
  }
  version.updateRoot();
  return version;
}

Result<SceneVersion> SceneVersion::apply(const Commit& commit) const {
  if (commit.revision != revision_ + 1) {
    return refused("revision", "commit " + std::to_string(commit.revision) + " does not follow revision " +
                                   std::to_string(revision_));
  }
  SceneVersion next = *this;
  next.revision_ = commit.revision;
  const auto place = [&](ObjectId id) {
    return std::ranges::lower_bound(next.objects_, id, {}, [](const Object& o) { return o->id; });
  };
  for (const ObjectId id : commit.removed) {
    const auto at = place(id);
    if (at == next.objects_.end() || (*at)->id != id) {
      return refused("removed", "there is no object " + std::to_string(id));
    }
    next.hashes_.erase(next.hashes_.begin() + (at - next.objects_.begin()));
    next.objects_.erase(at);
  }
  for (const ObjectRecord& record : commit.put) {
    if (record.id == 0) return refused("put.id", "0 is no object");
    if (record.name.empty()) return refused("put.name", "is empty");
    if (const Object same = next.find(record.name); same && same->id != record.id) {
      return refused("put.name", "object " + std::to_string(same->id) + " is already named \"" + record.name + "\"");
    }
    const auto at = place(record.id);
    const auto hashAt = next.hashes_.begin() + (at - next.objects_.begin());
    auto object = std::make_shared<const ObjectRecord>(record);
    if (at != next.objects_.end() && (*at)->id == record.id) {
      *at = std::move(object);
      *hashAt = record.hash();
    } else {
      next.hashes_.insert(hashAt, record.hash());
      next.objects_.insert(at, std::move(object));
    }
  }
  next.updateRoot();
  return next;
}

SceneVersion::Object SceneVersion::find(ObjectId id) const {
  const auto at = std::ranges::lower_bound(objects_, id, {}, [](const Object& o) { return o->id; });
  return at != objects_.end() && (*at)->id == id ? *at : nullptr;
}

SceneVersion::Object SceneVersion::find(const std::string& name) const {
  const auto at = std::ranges::find(objects_, name, [](const Object& o) { return o->name; });
  return at != objects_.end() ? *at : nullptr;
}

void SceneVersion::updateRoot() {
  Hasher h;
  h.add(revision_);
  for (std::size_t i = 0; i < objects_.size(); ++i) h.add(objects_[i]->id).add(objects_[i]->revision).add(hashes_[i]);
  root_ = h.finish();
}

std::string ObjectRef::text() const {
  if (const auto* id = std::get_if<ObjectId>(&value)) return "object " + std::to_string(*id);
  return "object \"" + std::get<std::string>(value) + "\"";
}

Pose edited(Pose pose, const PoseEdit& edit) {
  pose.position = edit.position.value_or(pose.position);
  pose.rotation = edit.rotation.value_or(pose.rotation);
  return pose;
}

Material edited(Material material, const MaterialEdit& edit) {
  material.stiffness_N_per_m = edit.stiffness_N_per_m.value_or(material.stiffness_N_per_m);
  material.damping_Ns_per_m = edit.damping_Ns_per_m.value_or(material.damping_Ns_per_m);
  material.color = edit.color.value_or(material.color);
  material.surface = edited(std::move(material.surface), edit.surface);
  return material;
}

}  // namespace haptics
