#include "haptic_server/world/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/import.h"
#include "common/telemetry/fault_words.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "haptic_server/step/haptic_step.h"

namespace haptics {
namespace {

/// A body that was removed stays for this long, so that a contact on it fades instead of snapping off.
constexpr double kRemovalFade_s = 0.5;
constexpr std::size_t kMaxNameLength = 64;
constexpr double kMaxStiffness_N_per_m = 1e5, kMaxDamping_Ns_per_m = 1e3, kMaxCoordinate_m = 1e3, kMaxFriction = 10;
constexpr double kMinRate_Hz = 100, kMaxRate_Hz = 2e4, kMaxDeviceForce_N = 1e3;

[[noreturn]] void refuse(const std::string& field, const std::string& reason) {
  throw InvalidInput(field + ": " + reason);
}

[[nodiscard]] std::string text(double value) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%g", value);
  return digits.data();
}

void check(double value, double least, double most, const char* unit, const std::string& field) {
  if (value >= least && value <= most) return;  // not for NaN
  refuse(field, "is " + text(value) + "; it is to be from " + text(least) + " to " + text(most) + unit);
}

[[nodiscard]] Vec3 vec(const World::Vector& v) noexcept { return {v[0], v[1], v[2]}; }
[[nodiscard]] World::Vector vectorOf(Vec3 v) noexcept { return {v.x, v.y, v.z}; }

[[nodiscard]] Pose poseOf(const World::Pose& pose) {
  for (std::size_t k = 0; k < 3; ++k) {
    check(pose.position_m[k], -kMaxCoordinate_m, kMaxCoordinate_m, " m", "pose.position_m[" + std::to_string(k) + "]");
  }
  const auto& [w, x, y, z] = pose.rotation;
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  constexpr double kTolerance = 1e-3;
  if (!(std::abs(length - 1) <= kTolerance))
    refuse("pose.rotation", "has length " + text(length) + "; a rotation is a unit quaternion (w, x, y, z)");
  return {Quat(w, x, y, z) / length, vec(pose.position_m)};
}

[[nodiscard]] SurfaceProperties propertiesOf(const World::Material& material) {
  check(material.stiffness_N_per_m, 0, kMaxStiffness_N_per_m, " N/m", "material.stiffness_N_per_m");
  check(material.damping_Ns_per_m, 0, kMaxDamping_Ns_per_m, " Ns/m", "material.damping_Ns_per_m");
  check(material.staticFriction, 0, kMaxFriction, "", "material.staticFriction");
  check(material.dynamicFriction, 0, material.staticFriction, " (the static one)", "material.dynamicFriction");
  check(material.roundedBelow_rad, 0, std::numbers::pi, " rad", "material.roundedBelow_rad");
  SurfaceProperties properties;
  if (material.staticFriction > 0)
    properties.friction = Friction{.mu_static = material.staticFriction, .mu_dynamic = material.dynamicFriction};
  if (material.roundedBelow_rad > 0)
    properties.shading = Shading{.crease_rad = material.roundedBelow_rad, .creases = {}};
  return properties;
}

[[nodiscard]] DeviceInfo infoOf(const World::Device& device) {
  check(device.rate_Hz, kMinRate_Hz, kMaxRate_Hz, " Hz", "device.rate_Hz");
  check(device.maxForce_N, 0, kMaxDeviceForce_N, " N", "device.maxForce_N");
  check(device.resolution_m, 0, 1, " m", "device.resolution_m");
  check(device.delay_s, 0, 1, " s", "device.delay_s");
  check(device.mass_kg, 0, 1e3, " kg", "device.mass_kg");
  check(device.viscousFriction_Ns_per_m, 0, 1e3, " Ns/m", "device.viscousFriction_Ns_per_m");
  check(device.coulombFriction_N, 0, 1e3, " N", "device.coulombFriction_N");
  check(device.maxStiffness_N_per_m, 0, 1e6, " N/m", "device.maxStiffness_N_per_m");
  DeviceInfo info;
  info.maxForce_N = device.maxForce_N;
  info.maxStiffness_N_per_m = device.maxStiffness_N_per_m;
  info.resolution_m = device.resolution_m;
  info.apparentMass_kg = device.mass_kg;
  info.viscousFriction_Ns_per_m = device.viscousFriction_Ns_per_m;
  info.coulombFriction_N = device.coulombFriction_N;
  info.delay_s = device.delay_s;
  return info;
}

[[nodiscard]] std::shared_ptr<const CollisionMesh> surfaceOf(const World::Mesh& mesh) {
  if (mesh.triangles.size() > kMaxTriangles || mesh.vertices.size() > kMaxVertices) {
    refuse("mesh", "has " + std::to_string(mesh.triangles.size()) + " triangles and " +
                       std::to_string(mesh.vertices.size()) + " vertices; at most " + std::to_string(kMaxTriangles) +
                       " of each are taken");
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v >= mesh.vertices.size()) {
        refuse("mesh.triangles[" + std::to_string(t) + "]", "names vertex " + std::to_string(v) + "; there are " +
                                                                std::to_string(mesh.vertices.size()) +
                                                                ", numbered from 0");
      }
    }
  }
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
  const auto made = canonicalise(vertices, {mesh.triangles.begin(), mesh.triangles.end()}, {});
  if (!made) refuse("mesh", made.error().text());
  return buildCollisionMesh(made->mesh.vertices, made->mesh.triangles);
}

[[nodiscard]] World::Fault faultOf(Fault fault) noexcept {
  switch (fault) {
    case Fault::kNonFiniteInput:
      return World::Fault::kNonFiniteHip;
    case Fault::kNonFiniteForce:
      return World::Fault::kNonFiniteForce;
    case Fault::kDeadlinesMissed:
      return World::Fault::kMissedTicks;
    default:
      return World::Fault::kNone;
  }
}

}  // namespace

World::Device World::Device::named(std::string_view name) {
  const auto preset = findDevicePreset(name);
  if (!preset) refuse("device", preset.error().reason);
  Device device;
  device.maxForce_N = preset->maxForce_N;
  device.resolution_m = preset->resolution_m;
  device.mass_kg = preset->apparentMass_kg;
  device.viscousFriction_Ns_per_m = preset->viscousFriction_Ns_per_m;
  device.coulombFriction_N = preset->coulombFriction_N;
  device.maxStiffness_N_per_m = preset->maxStiffness_N_per_m;
  return device;
}

struct World::Impl {
  struct Removal {
    std::uint64_t body;
    std::uint64_t tick;  // from which on it is no longer in the scene
  };

  explicit Impl(const Device& device)
      : info(infoOf(device)),
        config(serverStepConfig(info, device.rate_Hz)),
        limits(surfaceLimits(info, device.rate_Hz, true)),
        state(std::make_unique<HapticState>(config)),
        scene(std::make_unique<ServoScene>()) {}

  DeviceInfo info;
  StepConfig config;
  SurfaceLimits limits;
  std::vector<std::pair<std::uint64_t, std::string>> names;  // of the bodies that were not removed
  std::vector<ServoObject> bodies;                           // as edited last, in order of id
  std::vector<Removal> removals;
  std::uint64_t lastBody = 0, revision = 0, tick = 0, allowanceSpent = 0;

  std::unique_ptr<HapticState> state;
  std::unique_ptr<const ServoScene> scene;  // that the state has adopted
  std::unique_ptr<const ServoScene> next;   // that it is to adopt
  std::unique_ptr<const ServoScene> last;   // that it had adopted before: step() frees nothing

  [[nodiscard]] ServoObject& find(std::uint64_t body) {
    const auto at = std::ranges::find(bodies, body, &ServoObject::id);
    if (at == bodies.end() || at->pendingRemoval) refuse("body", "there is no body " + std::to_string(body));
    return *at;
  }

  void setMaterial(ServoObject& object, const Material& material) const {
    const SurfaceProperties properties = propertiesOf(material);
    object.stiffness_N_per_m = std::min(material.stiffness_N_per_m, limits.stiffness_N_per_m);
    object.damping_Ns_per_m = std::min(material.damping_Ns_per_m, limits.damping_Ns_per_m);
    object.detail = makeSurfaceDetail(*object.surface, properties, {});
  }

  /// Gives the step a scene of the bodies as they are now.
  void publish() {
    std::erase_if(removals, [this](const Removal& removal) {
      if (removal.tick > tick) return false;
      std::erase_if(bodies, [&](const ServoObject& object) { return object.id == removal.body; });
      return true;
    });
    auto made = std::make_unique<ServoScene>();
    made->number = made->revision = ++revision;
    made->objects = bodies;
    next = std::move(made);
    last.reset();
  }

  [[nodiscard]] Sample step(const Vector& hip) noexcept {
    if (next && adoptScene(*next, *state, tick)) {
      last = std::move(scene);
      scene = std::move(next);
    }
    StepInput input;
    input.tick = tick++;
    input.device.position = vec(hip);
    input.device.state = DeviceState::kReady;
    const TelemetrySample felt = hapticStep(*scene, *state, config, input);
    Sample sample;
    sample.force_N = vectorOf(felt.force.written);
    sample.ihip_m = vectorOf(felt.ihip);
    sample.normal = vectorOf(felt.surfaceNormal);
    sample.penetration_m = felt.penetration_m;
    sample.body = felt.object;
    sample.triangle = felt.primitive.polygon;
    sample.fault = faultOf(felt.fault);
    sample.sliding = felt.frictionState == FrictionState::kSliding;
    sample.allowanceSpent = felt.allowanceSpent != allowanceSpent;
    allowanceSpent = felt.allowanceSpent;
    return sample;
  }
};

World::World(const Device& device) : impl_(std::make_unique<Impl>(device)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

std::uint64_t World::add(std::string_view name, const Mesh& mesh, const Material& material, const Pose& pose) {
  if (name.empty() || name.size() > kMaxNameLength)
    refuse("name",
           "has " + std::to_string(name.size()) + " bytes; 1 to " + std::to_string(kMaxNameLength) + " will do");
  if (std::ranges::find(impl_->names, name, &std::pair<std::uint64_t, std::string>::second) != impl_->names.end())
    refuse("name", "a body called \"" + std::string(name) + "\" is already there; remove it first, or choose another");
  if (impl_->names.size() >= kMaxServoObjects)
    refuse("body", "there are " + std::to_string(kMaxServoObjects) + " already, which is the most");
  ServoObject object;
  object.pose = poseOf(pose);
  (void)propertiesOf(material);  // before the work on the mesh
  object.surface = surfaceOf(mesh);
  impl_->setMaterial(object, material);
  object.id = ++impl_->lastBody;
  impl_->names.emplace_back(object.id, name);
  if (impl_->bodies.size() == kMaxServoObjects) {  // one that fades makes room
    impl_->bodies.erase(std::ranges::find(impl_->bodies, true, &ServoObject::pendingRemoval));
  }
  impl_->bodies.push_back(std::move(object));
  impl_->publish();
  return impl_->lastBody;
}

void World::setPose(std::uint64_t body, const Pose& pose) {
  impl_->find(body).pose = poseOf(pose);
  impl_->publish();
}

void World::setMaterial(std::uint64_t body, const Material& material) {
  impl_->setMaterial(impl_->find(body), material);
  impl_->publish();
}

void World::remove(std::uint64_t body) {
  impl_->find(body).pendingRemoval = true;
  std::erase_if(impl_->names, [body](const auto& name) { return name.first == body; });
  impl_->removals.push_back({body, impl_->tick + static_cast<std::uint64_t>(kRemovalFade_s / impl_->config.period_s)});
  impl_->publish();
}

World::Sample World::step(const Vector& hip_m) noexcept { return impl_->step(hip_m); }

World::Sample World::step(const Vector& hip_m, std::uint64_t missedTicks) noexcept {
  impl_->tick += missedTicks;
  return impl_->step(hip_m);
}

void World::run(std::span<const Vector> hips_m, std::span<Sample> samples) noexcept {
  const std::size_t count = std::min(hips_m.size(), samples.size());
  for (std::size_t i = 0; i < count; ++i) samples[i] = impl_->step(hips_m[i]);
}

const char* faultInWords(World::Fault fault) noexcept {
  switch (fault) {
    case World::Fault::kNonFiniteHip:
      return faultInWords(Fault::kNonFiniteInput, DeviceFault::kNone);
    case World::Fault::kNonFiniteForce:
      return faultInWords(Fault::kNonFiniteForce, DeviceFault::kNone);
    case World::Fault::kMissedTicks:
      return faultInWords(Fault::kDeadlinesMissed, DeviceFault::kNone);
    default:
      return faultInWords(Fault::kNone, DeviceFault::kNone);
  }
}

}  // namespace haptics
