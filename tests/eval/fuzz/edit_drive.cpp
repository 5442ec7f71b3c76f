#include "tests/eval/fuzz/edit_drive.h"

#include <algorithm>

#include "common/surface/make_field.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

constexpr double kSliding = 0.7;  ///< Of the static friction.

StepConfig configOf(const EditRun& run) {
  StepConfig config{.period_s = run.period_s(), .maxForce_N = 1e9};
  if (run.device.empty()) return config;
  config = serverConfigFor(orThrow(findDevicePreset(run.device)), run.rate_Hz);
  if (!run.stabiliser) config.observer.reset();
  return config;
}

std::shared_ptr<const SurfaceDetail> detailOf(const CollisionMesh& surface, const FuzzObject& object) {
  SurfaceProperties properties;
  DetailFields fields;
  if (object.crease_rad > 0) properties.shading = Shading{object.crease_rad, {}};
  if (object.friction > 0)
    properties.friction = Friction{.mu_static = object.friction, .mu_dynamic = kSliding * object.friction, .over = {}};
  if (object.textureAmplitude_m > 0) {
    const auto law = object.bumpMapped ? Texture::Law::kBump : Texture::Law::kHo1999;
    const NoiseFamily noise{.wavelength_m = object.textureWavelength_m};
    properties.texture = Texture{.law = law, .family = noise, .amplitude_m = object.textureAmplitude_m};
    fields.texture = orThrow(makeField(noise, {}));
  }
  return makeSurfaceDetail(surface, properties, fields);
}

}  // namespace

EditDrive::EditDrive(const EditRun& run)
    : run_(run),
      config_(configOf(run)),
      state_(std::make_unique<HapticState>(config_)),
      scene_(std::make_shared<ServoScene>()) {}

std::shared_ptr<const CollisionMesh> EditDrive::surfaceOf(std::size_t mesh) {
  if (surfaces_.size() <= mesh) surfaces_.resize(mesh + 1);
  if (surfaces_[mesh]) return surfaces_[mesh];
  const EditRun::Mesh& from = run_.meshes[mesh];
  return surfaces_[mesh] =
             from.refitted ? refitCollisionMesh(*surfaceOf(*from.refitted), from.mesh.vertices) : from.mesh.build();
}

/// Hung by a spring as stiff as the hand presses, and well damped: it moves, and comes to rest.
std::shared_ptr<const RigidBody> EditDrive::bodyOf(const FuzzObject& object) {
  constexpr double kHeld_N_per_m = 500;
  constexpr double kHeld_Nm_per_rad = 0.5;
  const FuzzMesh& mesh = run_.meshes[object.mesh].mesh;
  RigidBody body = solidFrom({mesh.vertices, mesh.triangles}, object.mass_kg).body;
  body.spring = {.stiffness_N_per_m = kHeld_N_per_m, .stiffness_Nm_per_rad = kHeld_Nm_per_rad};
  body.spring.damping_Ns_per_m = 2 * std::sqrt(kHeld_N_per_m * object.mass_kg);
  body.angularDamping_per_s = 40;
  return std::make_shared<const RigidBody>(std::move(body));
}

ServoObject EditDrive::make(const FuzzObject& object) {
  const auto known = made_.find(object.id);
  const Made* before = known == made_.end() ? nullptr : &known->second;
  ServoObject made{object.id,
                   surfaceOf(object.mesh),
                   object.pose,
                   object.stiffness_N_per_m,
                   object.damping_Ns_per_m,
                   object.pendingRemoval};
  made.poseRevision = object.poseRevision;
  made.baked.shape = object.shape;
  made.detail = before && before->of.sameSurface(object) ? before->object.detail : detailOf(*made.surface, object);
  if (object.mass_kg > 0) {
    const bool same = before && before->of.mesh == object.mesh && before->of.mass_kg == object.mass_kg;
    made.motion = same ? before->object.motion : bodyOf(object);
  }
  if (object.tissue) {
    const bool same = before && before->of.tissue == object.tissue;
    made.tissue = same ? before->object.tissue : std::make_shared<const SoftTissue>(*object.tissue);
  }
  made_.insert_or_assign(object.id, Made{object, made});
  return made;
}

std::shared_ptr<const ServoScene> EditDrive::make(const FuzzScene& scene) {
  auto made = std::make_shared<ServoScene>();
  made->number = ++number_;
  made->revision = scene.revision;
  for (const FuzzObject& object : scene.objects) made->objects.push_back(make(object));
  std::erase_if(made_, [&](const auto& known) {
    return std::ranges::find(scene.objects, known.first, &FuzzObject::id) == scene.objects.end();
  });
  return made;
}

const TelemetrySample& EditDrive::step(Vec3 hip) {
  while (published_ < run_.scenes.size() && run_.scenes[published_].tick <= tick_) {
    waiting_ = make(run_.scenes[published_++]);
  }
  adoptedNow_ = waiting_ && adoptScene(*waiting_, *state_, tick_);
  if (adoptedNow_) scene_ = std::move(waiting_);
  sample_ = hapticStep(*scene_, *state_, config_, {tick_, 0, {hip, DeviceState::kReady, DeviceStatus{}}});
  ++tick_;
  return sample_;
}

void EditDrive::split() {
  twin_ = std::make_unique<HapticState>(*state_);
  twinScene_ = scene_;
}

/// After step(), of the same tick.
const TelemetrySample& EditDrive::stepTwin(Vec3 hip) {
  twinSample_ = hapticStep(*twinScene_, *twin_, config_, {tick_ - 1, 0, {hip, DeviceState::kReady, DeviceStatus{}}});
  return twinSample_;
}

const FuzzObject* EditDrive::object(std::uint64_t id) const {
  const auto known = made_.find(id);
  return known == made_.end() ? nullptr : &known->second.of;
}

}  // namespace haptics::eval
