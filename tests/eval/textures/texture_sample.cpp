#include "tests/eval/textures/texture_sample.h"

#include "common/mesh/generators.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {

TextureSample::TextureSample(std::shared_ptr<const CollisionMesh> surface, std::shared_ptr<const SurfaceDetail> detail,
                             const Feel& feel)
    : feel_(feel), state_(std::make_unique<HapticState>(feel.config)) {
  scene_.revision = 1;
  ServoObject object;
  object.id = 1;
  object.surface = std::move(surface);
  object.pose = feel.pose;
  object.stiffness_N_per_m = feel.stiffness_N_per_m;
  object.damping_Ns_per_m = feel.damping_Ns_per_m;
  object.detail = std::move(detail);
  scene_.objects.push_back(std::move(object));
  (void)adoptScene(scene_, *state_, 0);  // the first is always taken
}

void TextureSample::place(Vec3 hip) {
  state_->supervision.attached = false;
  (void)tick(hip);
}

Touch TextureSample::tick(Vec3 hip) {
  hip_ = hip;
  const StepInput input{tick_++, 0, {toWorld(feel_.pose, hip), DeviceState::kReady}};
  const TelemetrySample sample = hapticStep(scene_, *state_, feel_.config, input);
  const Quat turn = glm::conjugate(feel_.pose.rotation);
  Touch touch;
  touch.touching = sample.object != 0;
  touch.ihip = toLocal(feel_.pose, sample.ihip);
  touch.normal = turn * sample.surfaceNormal;
  touch.height_m = sample.height_m;
  touch.force = sample.force;
  for (Vec3* force : {&touch.force.spring, &touch.force.damping, &touch.force.friction, &touch.force.texture,
                      &touch.force.contact, &touch.force.written}) {
    *force = turn * *force;
  }
  touch.friction = sample.frictionState;
  touch.stickingPoint = toLocal(feel_.pose, sample.stickingPoint);
  return touch;
}

const TriMesh& boardMesh() {
  static const TriMesh mesh = [] {
    constexpr double kThick_m = 0.02;
    TriMesh box = orThrow(makeBox({0.12, 0.12, kThick_m}, 3));
    for (Vec3f& v : box.vertices) v.z -= static_cast<float>(kThick_m / 2);
    return box;
  }();
  return mesh;
}

std::shared_ptr<const CollisionMesh> boardSurface() {
  static const std::shared_ptr<const CollisionMesh> surface =
      buildCollisionMesh(boardMesh().vertices, boardMesh().triangles);
  return surface;
}

std::shared_ptr<const SurfaceDetail> boardDetail(const SurfaceProperties& properties, const TextureCase* texture,
                                                 const TextureCase* friction) {
  return makeSurfaceDetail(*boardSurface(), properties,
                           {texture ? texture->field : nullptr, friction ? friction->field : nullptr, nullptr});
}

}  // namespace haptics::eval
