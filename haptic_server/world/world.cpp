#include "haptic_server/world/world.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/import.h"
#include "common/telemetry/fault_words.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/world/held_tool.h"
#include "haptic_server/world/input_checks.h"
#include "haptic_server/world/stepped_scene.h"
#include "haptic_server/world/vertex_stream.h"

namespace haptics {
namespace {

/// A body that was removed stays for this long, so that a contact on it fades instead of snapping off.
constexpr double kRemovalFade_s = 0.5;
constexpr std::size_t kMaxNameLength = 64;
constexpr double kMaxStiffness_N_per_m = 1e5, kMaxDamping_Ns_per_m = 1e3, kMaxCoordinate_m = 1e3, kMaxFriction = 10;

[[nodiscard]] Pose poseOf(const World::Pose& pose) {
  constexpr std::array kFields{"pose.position_m[0]", "pose.position_m[1]", "pose.position_m[2]"};
  for (std::size_t k = 0; k < 3; ++k) check(pose.position_m[k], -kMaxCoordinate_m, kMaxCoordinate_m, " m", kFields[k]);
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

[[nodiscard]] ImportedMesh canonicalMesh(const World::Mesh& mesh) {
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
  auto made = canonicalise(vertices, {mesh.triangles.begin(), mesh.triangles.end()}, {});
  if (!made) refuse("mesh", made.error().text());
  return *std::move(made);
}

[[nodiscard]] std::shared_ptr<const CollisionMesh> surfaceOf(const World::Mesh& mesh) {
  const TriMesh canonical = canonicalMesh(mesh).mesh;
  return buildCollisionMesh(canonical.vertices, canonical.triangles);
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

  explicit Impl(const Device& device) : scene(device) {}

  std::vector<std::pair<std::uint64_t, std::string>> names;  // of the bodies that were not removed
  std::vector<ServoObject> bodies;                           // as edited last, in order of id
  std::map<std::uint64_t, KinematicPose> driven;             // of each of them: moveKinematic() adds none
  std::map<std::uint64_t, VertexStream> vertices;            // likewise
  std::vector<Removal> removals;
  std::uint64_t lastBody = 0, revision = 0, lastSample = 0;
  SteppedScene scene;
  std::optional<HeldTool> tool;

  [[nodiscard]] ServoObject& find(std::uint64_t body) {
    const auto at = std::ranges::find(bodies, body, &ServoObject::id);
    if (at == bodies.end() || at->pendingRemoval) refuse("body", "there is no body " + std::to_string(body));
    return *at;
  }

  [[nodiscard]] bool isReshaped(std::uint64_t body) const {
    const auto at = vertices.find(body);
    return at != vertices.end() && at->second.shape().number != 0;
  }

  void setMaterial(ServoObject& object, const Material& material) const {
    const SurfaceProperties properties = propertiesOf(material);
    if (properties.shading && isReshaped(object.id)) {
      refuse("material.roundedBelow_rad",
             "is " + text(material.roundedBelow_rad) + " of a body whose vertices were moved; 0 will do");
    }
    object.stiffness_N_per_m = std::min(material.stiffness_N_per_m, scene.limits().stiffness_N_per_m);
    object.damping_Ns_per_m = std::min(material.damping_Ns_per_m, scene.limits().damping_Ns_per_m);
    object.detail = makeSurfaceDetail(*object.surface, properties, {});
  }

  /// Gives the step a scene of the bodies as they are now.
  void publish() {
    std::erase_if(removals, [this](const Removal& removal) {
      if (removal.tick > scene.tick()) return false;
      std::erase_if(bodies, [&](const ServoObject& object) { return object.id == removal.body; });
      return true;
    });
    auto made = std::make_unique<ServoScene>();
    made->number = made->revision = ++revision;
    made->objects = bodies;
    std::erase_if(driven, [this](const auto& entry) {
      return std::ranges::find(bodies, entry.first, &ServoObject::id) == bodies.end();
    });
    for (const ServoObject& object : bodies) {
      made->kinematic.push_back(driven[object.id]);
      made->shapes.push_back(vertices.at(object.id).shape());
    }
    std::erase_if(vertices, [this](const auto& entry) { return !driven.contains(entry.first); });
    if (tool) tool->adopt(*made);
    scene.publish(std::move(made));
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
  ImportedMesh canonical = canonicalMesh(mesh);
  object.surface = buildCollisionMesh(canonical.mesh.vertices, canonical.mesh.triangles);
  impl_->setMaterial(object, material);
  object.id = impl_->lastBody + 1;
  impl_->vertices.emplace(object.id, VertexStream(mesh.vertices.size(), std::move(canonical)));
  ++impl_->lastBody;
  impl_->names.emplace_back(object.id, name);
  if (impl_->bodies.size() == kMaxServoObjects) {  // one that fades makes room
    impl_->bodies.erase(std::ranges::find(impl_->bodies, true, &ServoObject::pendingRemoval));
  }
  impl_->bodies.push_back(std::move(object));
  impl_->publish();
  return impl_->lastBody;
}

void World::setPose(std::uint64_t body, const Pose& pose) {
  ServoObject& object = impl_->find(body);
  object.pose = poseOf(pose);
  impl_->driven[body] = {};
  object.poseRevision = impl_->revision + 1;
  impl_->publish();
}

void World::moveKinematic(std::uint64_t body, const Pose& pose) {
  static_cast<void>(impl_->find(body));
  KinematicPose& sample = impl_->driven[body];
  sample = {impl_->lastSample + 1, poseOf(pose)};
  ++impl_->lastSample;
  impl_->scene.drive(body, sample);
  if (impl_->tool) impl_->tool->drive(body, sample.pose);
}

void World::moveVerticesKinematic(std::uint64_t body, std::span<const std::array<float, 3>> vertices) {
  const ServoObject& object = impl_->find(body);
  if (impl_->tool) refuse("body", "has vertices that a tool in the hand would not feel move: hold none");
  if (object.detail && object.detail->shading)
    refuse("body", "is rounded, for normals that do not move with its vertices; material.roundedBelow_rad: 0 will do");
  VertexStream& stream = impl_->vertices.at(body);
  stream.take(vertices, *object.surface);
  impl_->scene.drive(body, stream.shape());
}

void World::setMaterial(std::uint64_t body, const Material& material) {
  impl_->setMaterial(impl_->find(body), material);
  impl_->publish();
}

void World::remove(std::uint64_t body) {
  impl_->find(body).pendingRemoval = true;
  std::erase_if(impl_->names, [body](const auto& name) { return name.first == body; });
  const SteppedScene& scene = impl_->scene;
  impl_->removals.push_back(
      {body, scene.tick() + static_cast<std::uint64_t>(kRemovalFade_s / scene.config().period_s)});
  impl_->publish();
}

std::size_t World::hold(const Mesh& mesh, const Tool& tool) {
  for (const ServoObject& object : impl_->bodies) {
    if (impl_->isReshaped(object.id))
      refuse("tool", "does not feel the vertices of body " + std::to_string(object.id) + " move, which were moved");
  }
  HeldTool held(surfaceOf(mesh), tool, impl_->scene.config());
  const std::size_t points = held.points();
  impl_->tool = std::move(held);
  impl_->publish();
  return points;
}

World::ToolSample World::stepTool(const Pose& device) noexcept {
  return impl_->tool ? impl_->tool->step(device) : ToolSample{};
}

World::Sample World::step(const Vector& hip_m) noexcept { return impl_->scene.step(hip_m); }

World::Sample World::step(const Vector& hip_m, std::uint64_t missedTicks) noexcept {
  impl_->scene.miss(missedTicks);
  return impl_->scene.step(hip_m);
}

void World::run(std::span<const Vector> hips_m, std::span<Sample> samples) noexcept {
  impl_->scene.run(hips_m, samples);
}

void World::runTool(std::span<const Pose> devices, std::span<ToolSample> samples) noexcept {
  const std::size_t count = std::min(devices.size(), samples.size());
  for (std::size_t i = 0; i < count; ++i) samples[i] = stepTool(devices[i]);
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
