#include "graphics_client/editing/scene_text.h"

#include <google/protobuf/text_format.h>

#include "common/wire/convert.h"

namespace haptics {

v1::AddObject additionOf(const ObjectRecord& record) {
  v1::ObjectState state;
  toWire(record, state);
  v1::AddObject add;
  add.set_name(state.name());
  add.mutable_mesh()->set_asset(state.mesh());
  *add.mutable_pose() = state.pose();
  add.mutable_material()->set_stiffness_n_per_m(state.stiffness_n_per_m());
  add.mutable_material()->set_damping_ns_per_m(state.damping_ns_per_m());
  *add.mutable_material()->mutable_color() = state.color();
  if (state.has_shading()) *add.mutable_material()->mutable_shading() = state.shading();
  if (state.has_friction()) *add.mutable_material()->mutable_friction() = state.friction();
  if (state.has_texture()) *add.mutable_material()->mutable_texture() = state.texture();
  if (state.has_stiffness_over()) *add.mutable_material()->mutable_stiffness_over() = state.stiffness_over();
  if (state.has_softness_over()) *add.mutable_material()->mutable_softness_over() = state.softness_over();
  if (state.has_motion()) *add.mutable_motion() = state.motion();
  if (state.has_deformation()) *add.mutable_deformation() = state.deformation();
  return add;
}

std::string sceneText(const SceneVersion& scene, const std::string& name) {
  v1::Transaction transaction;
  for (const auto& object : scene.objects()) {
    if (!name.empty() && object->name != name) continue;
    *transaction.add_operations()->mutable_add() = additionOf(*object);
  }
  std::string text;
  google::protobuf::TextFormat::PrintToString(transaction, &text);
  return text;
}

}  // namespace haptics
