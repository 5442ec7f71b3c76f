#include "tests/eval/moving_world.h"

#include <algorithm>
#include <stdexcept>

#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/step/two_hands.h"

namespace haptics::eval {
namespace {

/// Ticks for which a removed object stays.
constexpr std::uint64_t kLeaving = 500;

}  // namespace

std::unique_ptr<BodyWorld> Renderer::makeBodyWorld() const { return std::make_unique<MovingWorld>(); }

MovingSolid solidFrom(const TriMesh& mesh, double mass_kg) {
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  MovingSolid made{buildCollisionMesh(mesh.vertices, mesh.triangles), {}};
  const MassDefect defect =
      spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, made.body.mass);
  if (solid.defect != SolidDefect::kNone || defect != MassDefect::kNone) throw std::logic_error("not a body");
  made.body.setSupport(supportPoints(mesh.vertices));
  made.body.gravity_m_per_s2 = Vec3(0);
  return made;
}

std::uint64_t MovingWorld::add(const MovingSolid& solid, const Pose& pose, bool moves) {
  ServoObject object{++lastId_, solid.surface, pose, kSpring_N_per_m, 0};
  if (moves) object.motion = std::make_shared<RigidBody>(solid.body);
  objects_.push_back(std::move(object));
  return lastId_;
}

ServoObject& MovingWorld::object(std::uint64_t id) { return *std::ranges::find(objects_, id, &ServoObject::id); }

void MovingWorld::setPose(std::uint64_t id, const Pose& pose) {
  object(id).pose = pose;
  object(id).poseRevision = revision_ + 1;
}

void MovingWorld::remove(std::uint64_t id) {
  leaving_.push_back(object(id));
  leaving_.back().pendingRemoval = true;
  leaving_.back().poseRevision = tick_;  // of no further use to the step; here: since when
  std::erase_if(objects_, [id](const ServoObject& o) { return o.id == id; });
}

void MovingWorld::publish() {
  auto scene = std::make_shared<ServoScene>();
  scene->revision = ++revision_;
  std::erase_if(leaving_, [this](const ServoObject& o) { return tick_ - o.poseRevision > kLeaving; });
  scene->objects = objects_;
  for (const ServoObject& object : leaving_) {
    scene->objects.push_back(object);
    if (const int i = indexOf(object.id); i >= 0) {
      scene->objects.back().poseRevision = state_.objects[static_cast<std::size_t>(i)].poseRevision;
    }
  }
  std::ranges::sort(scene->objects, {}, &ServoObject::id);
  waiting_.push_back(std::move(scene));
}

TelemetrySample MovingWorld::tick(Vec3 hip) {
  if (!waiting_.empty() && adoptScene(*waiting_.back(), state_, tick_)) {
    scene_ = waiting_.back();
    waiting_.clear();
    if (overlooksPut_) {
      for (std::size_t i = 0; i < state_.collidingCount; ++i) state_.colliding[i].isPut = false;
    }
  }
  TelemetrySample sample = hapticStep(*scene_, state_, config_, {tick_++, 0, {hip, DeviceState::kReady}});
  if (spoils != nullptr) spoils(sample);
  return sample;
}

MovingWorld::HandSamples MovingWorld::tick(Vec3 hip, Vec3 secondHip) {
  if (!second_) {
    second_ = std::make_unique<HapticState>(config_);
    followFirstHand(*second_);
    if (waiting_.empty()) waiting_.push_back(scene_);
  }
  if (!waiting_.empty()) {
    const bool first = adoptScene(*waiting_.back(), state_, tick_),
               second = adoptScene(*waiting_.back(), *second_, tick_);
    if (!first || !second) throw std::logic_error("both hands are to be free when a scene is published");
    scene_ = waiting_.back();
    waiting_.clear();
  }
  const StepInput input{tick_, 0, {hip, DeviceState::kReady}}, secondInput{tick_, 0, {secondHip, DeviceState::kReady}};
  ++tick_;
  ForceResult result, secondResult;
  computeForce(*scene_, state_, config_, input, result);
  computeForce(*scene_, *second_, config_, secondInput, secondResult);
  HandSamples samples;
  finishSteps({*scene_, state_, config_, input, result}, {*scene_, *second_, config_, secondInput, secondResult},
              samples.first, samples.second);
  if (spoils != nullptr) spoils(samples.second);
  return samples;
}

int MovingWorld::indexOf(std::uint64_t id) const noexcept {
  for (std::size_t i = 0; i < state_.objects.count; ++i) {
    if (state_.objects[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

const Pose& MovingWorld::poseOf(std::uint64_t id) const {
  return state_.bodies[static_cast<std::size_t>(indexOf(id))].current;
}

const RigidState& MovingWorld::stateOf(std::uint64_t id) const {
  const auto body = static_cast<std::size_t>(indexOf(id));
  return std::ranges::find(state_.moving.all(), body, &MovingBody::body)->state;
}

double MovingWorld::depthIn(std::size_t index, Vec3 point) const {
  const Body& body = state_.bodies[index];
  const CollisionMesh& surface = *body.surface;
  const Vec3 local = body.frame.toLocal(point);
  if (glm::any(glm::lessThan(local, surface.low())) || glm::any(glm::greaterThan(local, surface.high()))) return 0;
  int spent = 0;
  const ClosestPoint foot = surface.closestFoot(local, static_cast<int>(surface.triangleCount()) + 1, spent);
  return surface.isOutside(foot, local) ? 0 : std::sqrt(foot.squaredDistance);
}

double MovingWorld::energyOf(std::uint64_t id) const {
  for (std::size_t i = 0; i < state_.moving.count; ++i) {
    const MovingBody& moving = state_.moving[i];
    if (state_.objects[moving.body].id == id) return haptics::energyOf(state_.rigidBody(moving), moving.state);
  }
  return 0;
}

}  // namespace haptics::eval
