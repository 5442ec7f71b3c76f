#include "graphics_client/editing/scene_text.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

#include "common/wire/convert.h"

namespace haptics {

namespace pb = google::protobuf;

namespace {

/// Each field of a material is one of a state, by the same name.
void copyMaterial(const v1::ObjectState& state, v1::Material& material) {
  const pb::Reflection &from = *state.GetReflection(), &to = *material.GetReflection();
  for (int i = 0; i < material.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor* const field = material.GetDescriptor()->field(i);
    const pb::FieldDescriptor* const source = state.GetDescriptor()->FindFieldByName(field->name());
    if (field->message_type() == nullptr) {
      to.SetDouble(&material, field, from.GetDouble(state, source));
    } else if (from.HasField(state, source)) {
      to.MutableMessage(&material, field)->CopyFrom(from.GetMessage(state, source));
    }
  }
}

/// @param present  Makes of an object what is added.
template <class Present>
[[nodiscard]] v1::Transaction additionsOf(const SceneVersion& scene, const std::string& name, Present present) {
  v1::Transaction transaction;
  for (const auto& object : scene.objects()) {
    if (!name.empty() && object->name != name) continue;
    *transaction.add_operations()->mutable_add() = additionOf(present(*object));
  }
  return transaction;
}

}  // namespace

v1::AddObject additionOf(const ObjectRecord& record) {
  v1::ObjectState state;
  toWire(record, state);
  v1::AddObject add;
  add.set_name(state.name());
  add.mutable_mesh()->set_asset(state.mesh());
  *add.mutable_pose() = state.pose();
  copyMaterial(state, *add.mutable_material());
  if (state.has_motion()) *add.mutable_motion() = state.motion();
  if (state.has_deformation()) *add.mutable_deformation() = state.deformation();
  *add.mutable_effects() = state.effects();
  return add;
}

std::string sceneText(const SceneVersion& scene, const std::string& name) {
  return textOf(additionsOf(scene, name, [](const ObjectRecord& object) { return object; }));
}

v1::Transaction additionsOf(const MirrorView& view, const std::string& name) {
  return additionsOf(*view.scene, name, [&](ObjectRecord object) {
    if (!object.movesByItself()) object.pose = view.poseOf(object);
    object.deformation = view.deformationOf(object);
    return object;
  });
}

std::string textOf(const v1::Transaction& transaction) {
  std::string text;
  pb::TextFormat::PrintToString(transaction, &text);
  return text;
}

}  // namespace haptics
