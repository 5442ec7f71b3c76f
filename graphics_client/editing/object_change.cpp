#include "graphics_client/editing/object_change.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "common/wire/convert.h"
#include "graphics_client/editing/scene_text.h"

namespace haptics {
namespace {

namespace pb = google::protobuf;

enum Property : std::size_t {
  kMesh,
  kPosition,
  kRotation,
  kMotion,
  kSoftness,
  kLattice,
  kResidue,
  kEffects,
  kMaterial  ///< A field of the material: beyond this by its number.
};

/// Calls visit(property, its value in each of the records...).
template <class Visit, class... Records>
void forEachProperty(const Visit& visit, Records&... records) {
  visit(kMesh, records.mesh...);
  visit(kPosition, records.pose.position...);
  visit(kRotation, records.pose.rotation...);
  visit(kMotion, records.motion...);
  visit(kSoftness, records.deformation.softness...);
  visit(kLattice, records.deformation.lattice...);
  visit(kResidue, records.deformation.residue...);
  visit(kEffects, records.effects...);
  forEachMaterialScalar(
      [&visit](std::string_view name, auto&... values) {
        visit(kMaterial + std::size_t(materialScalar(name).number()), values...);
      },
      records.material...);
  using M = v1::Material;
  visit(kMaterial + std::size_t{M::kColorFieldNumber}, records.material.color...);
  visit(kMaterial + std::size_t{M::kShadingFieldNumber}, records.material.surface.shading...);
  visit(kMaterial + std::size_t{M::kFrictionFieldNumber}, records.material.surface.friction...);
  visit(kMaterial + std::size_t{M::kTextureFieldNumber}, records.material.surface.texture...);
  visit(kMaterial + std::size_t{M::kStiffnessOverFieldNumber}, records.material.surface.stiffnessOver...);
  visit(kMaterial + std::size_t{M::kSoftnessOverFieldNumber}, records.material.surface.softnessOver...);
}

PropertySet differences(const ObjectRecord& a, const ObjectRecord& b) {
  PropertySet different;
  const auto compare = [&](std::size_t property, const auto& its, const auto& other) {
    different[property] = !(its == other);
  };
  forEachProperty(compare, a, b);
  return different;
}

/// `to` with these properties of `from`.
SceneVersion::Object withProperties(const ObjectRecord& to, const PropertySet& properties, const ObjectRecord& from) {
  ObjectRecord record = to;
  const auto copy = [&](std::size_t property, auto& its, const auto& other) {
    if (properties[property]) its = other;
  };
  forEachProperty(copy, record, from);
  return std::make_shared<const ObjectRecord>(std::move(record));
}

PropertySet setBy(const v1::Material& material) {
  std::vector<const pb::FieldDescriptor*> fields;
  material.GetReflection()->ListFields(material, &fields);
  PropertySet set;
  for (const pb::FieldDescriptor* field : fields) set.set(kMaterial + std::size_t(field->number()));
  return set;
}

/// A residue goes with the shape that it was left on.
PropertySet setBy(const v1::Deformation& deformation) {
  PropertySet set;
  set[kSoftness] = deformation.has_softness();
  set[kLattice] = deformation.has_lattice();
  set[kResidue] = deformation.has_residue() || deformation.has_lattice();
  return set;
}

const v1::ObjectRef* objectOf(const v1::Operation& operation) {
  if (operation.has_remove()) return &operation.remove().object();
  if (operation.has_remesh()) return &operation.remesh().object();
  if (operation.has_set_pose()) return &operation.set_pose().object();
  if (operation.has_set_material()) return &operation.set_material().object();
  if (operation.has_set_motion()) return &operation.set_motion().object();
  if (operation.has_set_deformation()) return &operation.set_deformation().object();
  if (operation.has_set_effects()) return &operation.set_effects().object();
  return nullptr;
}

PropertySet setBy(const v1::Operation& operation) {
  PropertySet set;
  if (operation.has_add() || operation.has_remove()) set.set();
  if (operation.has_remesh()) set.set(kMesh).set(kResidue);
  if (operation.has_set_pose()) {
    set[kPosition] = operation.set_pose().pose().has_position();
    set[kRotation] = operation.set_pose().pose().has_rotation();
  }
  if (operation.has_set_material()) set = setBy(operation.set_material().material());
  if (operation.has_set_motion()) set.set(kMotion);
  if (operation.has_set_deformation()) set = setBy(operation.set_deformation().deformation());
  if (operation.has_set_effects()) set.set(kEffects);
  return set;
}

/// Empty: the scene has no object of that id.
std::string nameOf(const v1::Operation& operation, const SceneVersion& scene) {
  if (operation.has_add()) return operation.add().name();
  const v1::ObjectRef* object = objectOf(operation);
  if (object == nullptr || !object->has_id()) return object == nullptr ? std::string() : object->name();
  const auto known = scene.find(object->id());
  return known ? known->name : std::string();
}

v1::Material materialOf(v1::Material material, const PropertySet& set) {
  const pb::Descriptor& fields = *v1::Material::descriptor();
  for (int i = 0; i < fields.field_count(); ++i) {
    const pb::FieldDescriptor* const field = fields.field(i);
    if (!set[kMaterial + std::size_t(field->number())]) {
      material.GetReflection()->ClearField(&material, field);
    } else if (field->message_type() != nullptr) {
      material.GetReflection()->MutableMessage(&material, field);
    }
  }
  return material;
}

/// What makes `to` of `from`. A property that `to` does not have is given as an empty message, which takes it away.
void addOperations(ObjectId id, const ObjectRecord& from, const ObjectRecord& to, v1::Transaction& transaction) {
  PropertySet set = differences(from, to);
  const bool isReshaped = set[kMesh] || set[kLattice];
  set[kResidue] = isReshaped ? to.deformation.residue.has_value() : set[kResidue];
  const v1::AddObject whole = additionOf(to);
  if (set[kMesh]) {
    v1::RemeshObject& remesh = *transaction.add_operations()->mutable_remesh();
    remesh.mutable_object()->set_id(id);
    *remesh.mutable_mesh() = whole.mesh();
  }
  if (set[kPosition] || set[kRotation]) {
    v1::SetPose& pose = *transaction.add_operations()->mutable_set_pose();
    pose.mutable_object()->set_id(id);
    if (set[kPosition]) *pose.mutable_pose()->mutable_position() = whole.pose().position();
    if (set[kRotation]) *pose.mutable_pose()->mutable_rotation() = whole.pose().rotation();
  }
  if (const v1::Material part = materialOf(whole.material(), set); part.ByteSizeLong() > 0) {
    v1::SetMaterial& material = *transaction.add_operations()->mutable_set_material();
    material.mutable_object()->set_id(id);
    *material.mutable_material() = part;
  }
  if (set[kMotion]) {
    v1::SetMotion& motion = *transaction.add_operations()->mutable_set_motion();
    motion.mutable_object()->set_id(id);
    *motion.mutable_motion() = whole.motion();
  }
  if (set[kSoftness] || set[kLattice] || set[kResidue]) {
    v1::SetDeformation& set_deformation = *transaction.add_operations()->mutable_set_deformation();
    set_deformation.mutable_object()->set_id(id);
    v1::Deformation& part = *set_deformation.mutable_deformation();
    if (set[kSoftness]) *part.mutable_softness() = whole.deformation().softness();
    if (set[kLattice]) *part.mutable_lattice() = whole.deformation().lattice();
    if (set[kResidue]) *part.mutable_residue() = whole.deformation().residue();
  }
  if (set[kEffects]) {
    v1::SetEffects& effects = *transaction.add_operations()->mutable_set_effects();
    effects.mutable_object()->set_id(id);
    *effects.mutable_effects() = whole.effects();
  }
}

/// Null wherever one of them is.
SceneVersion::Object joinedBefore(const ObjectChange& first, const ObjectChange& second) {
  if (!first.before || !first.after || !second.before) return first.before;
  return withProperties(*second.before, differences(*first.before, *first.after), *first.before);
}

}  // namespace

std::vector<EditedObject> objectsEditedBy(const v1::Transaction& transaction, const SceneVersion& scene) {
  std::map<std::string, EditedObject> edited;
  for (const auto& operation : transaction.operations()) {
    const std::string name = nameOf(operation, scene);
    if (name.empty()) continue;
    EditedObject& object = edited[name];
    object.properties |= setBy(operation);
    object.isRemoved = operation.has_remove();
  }
  std::vector<EditedObject> objects;
  for (auto& [name, object] : edited) {
    object.name = name;
    object.before = scene.find(name);
    objects.push_back(std::move(object));
  }
  return objects;
}

ObjectChange changeOf(const EditedObject& edited, const SceneVersion::Object& before, SceneVersion::Object after) {
  if (!before || !after) return {edited.name, before, std::move(after)};
  return {edited.name, withProperties(*after, edited.properties, *before), std::move(after)};
}

Changes joined(Changes first, const Changes& second) {
  for (const ObjectChange& change : second) {
    const auto known = std::ranges::find(first, change.name, &ObjectChange::name);
    if (known == first.end()) {
      first.push_back(change);
    } else {
      *known = {change.name, joinedBefore(*known, change), change.after};
    }
  }
  std::erase_if(first, [](const ObjectChange& change) { return !isChange(change); });
  return first;
}

Changes reversed(Changes changes) {
  for (ObjectChange& change : changes) std::swap(change.before, change.after);
  return changes;
}

bool isChange(const ObjectChange& change) {
  if (!change.before || !change.after) return change.before != change.after;
  return differences(*change.before, *change.after).any();
}

Result<void> checkApplies(const Changes& changes, const SceneVersion& scene, const std::set<std::string>& skipped) {
  for (const ObjectChange& change : changes) {
    const auto present = scene.find(change.name);
    const char* what = nullptr;
    if (present && !change.before) what = "added";
    if (!present && change.before) what = "removed";
    if (present && change.before && differences(*present, *change.before).reset(kResidue).any()) what = "changed";
    if (what == nullptr) continue;
    const char* who = skipped.contains(change.name) ? "somebody else, or an edit that was skipped," : "somebody else";
    return refused("object \"" + change.name + "\"",
                   std::string("was ") + what + " by " + who + " since; that is not overwritten");
  }
  return {};
}

v1::Transaction transactionFor(const Changes& changes, const SceneVersion& scene) {
  v1::Transaction transaction;
  for (const ObjectChange& change : changes) {
    const auto present = scene.find(change.name);
    if (!present) continue;
    v1::Precondition& precondition = *transaction.add_preconditions();
    precondition.mutable_object()->set_id(present->id);
    precondition.set_expected_revision(present->revision);
    precondition.set_expected_hash(present->hash().asBytes());
    if (!change.after) transaction.add_operations()->mutable_remove()->mutable_object()->set_id(present->id);
  }
  for (const ObjectChange& change : changes) {
    const auto present = scene.find(change.name);
    if (!change.after) continue;
    if (present) {
      addOperations(present->id, *change.before, *change.after, transaction);
    } else {
      *transaction.add_operations()->mutable_add() = additionOf(*change.after);
    }
  }
  return transaction;
}

}  // namespace haptics
