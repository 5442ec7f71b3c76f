#include "tests/eval/runtime_method.h"

#include <algorithm>

#include "haptic_server/engine/step/surface_stages.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

constexpr auto kLeavingTicks = static_cast<std::uint64_t>(kRemovalFade_ns * 1e-9 / kPeriod_s);

}  // namespace

std::unique_ptr<BodyWorld> MethodThatOverlooksPutBodies::makeBodyWorld() const {
  return std::make_unique<MovingWorld>(true);
}

std::shared_ptr<const SurfaceDetail> RuntimeMethod::detailOf(const std::shared_ptr<const CollisionMesh>& surface) {
  if (!surface_ && !shading_) return nullptr;
  const auto [detail, isNew] = details_.try_emplace(surface);
  if (!isNew) return detail->second;
  SurfaceProperties properties = surface_ ? surface_->properties : SurfaceProperties{};
  if (shading_) properties.shading = shading_;
  detail->second = makeSurfaceDetail(*surface, properties, {surface_ ? surface_->texture : nullptr, nullptr, nullptr});
  return detail->second;
}

ServoObject RuntimeMethod::makeObject(std::uint64_t id, const std::shared_ptr<const CollisionMesh>& surface,
                                      const Pose& pose, double spring_N_per_m) {
  return {.id = id,
          .surface = surface,
          .pose = pose,
          .stiffness_N_per_m = spring_N_per_m,
          .detail = detailOf(surface),
          .tissue = tissue_};
}

void RuntimeMethod::begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
                          Vec3 hip) {
  auto scene = std::make_unique<ServoScene>();
  scene->revision = 1;
  ids_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    ids_.push_back(i + 1);
    scene->objects.push_back(
        makeObject(i + 1, bodies[i], poses[i], surface_ ? surface_->spring_N_per_m : kSpring_N_per_m));
  }
  poses_.assign(poses.begin(), poses.end());
  next_ = std::move(scene);
  state_ = HapticState(config_);
  removedAt_.clear();
  tick_ = 0;
  adopt();
  place(hip);
}

void RuntimeMethod::edit(const EditedScene& edited, Vec3 /*hip*/) {
  auto scene = std::make_unique<ServoScene>();
  scene->revision = scene_->revision + 1;
  for (std::size_t i = 0; i < edited.bodies.size(); ++i) {
    const auto before = std::ranges::find(scene_->objects, edited.ids[i], &ServoObject::id);
    const bool kept = before != scene_->objects.end() && before->surface == edited.bodies[i];
    if (kept) {
      scene->objects.push_back(*before);
      scene->objects.back().pose = edited.poses[i];
      scene->objects.back().stiffness_N_per_m = edited.spring_N_per_m;
    } else {
      scene->objects.push_back(makeObject(edited.ids[i], edited.bodies[i], edited.poses[i], edited.spring_N_per_m));
    }
  }
  for (const ServoObject& object : scene_->objects) {
    if (std::ranges::find(edited.ids, object.id) != edited.ids.end()) continue;
    if (tick_ > removedAt_.try_emplace(object.id, tick_).first->second + kLeavingTicks) continue;
    scene->objects.push_back(object);
    scene->objects.back().pendingRemoval = true;
  }
  std::ranges::sort(scene->objects, {}, &ServoObject::id);
  ids_.assign(edited.ids.begin(), edited.ids.end());
  poses_.assign(edited.poses.begin(), edited.poses.end());
  next_ = std::move(scene);
}

void RuntimeMethod::setSurfaceProperties(const FeltSurface& surface) {
  surface_ = surface;
  details_.clear();
  tissue_ = surface.tissue ? std::make_shared<const SoftTissue>(*surface.tissue) : nullptr;
  config_ = stepConfigFor(surface.device, 1 / kPeriod_s);
}

std::vector<Dent> RuntimeMethod::dents(std::size_t body) const {
  std::vector<Dent> dents;
  for (const BodyDent& dent : state_.allDents()) {
    if (state_.objects[dent.body].id == ids_[body]) dents.push_back(dent.dent);
  }
  return dents;
}

double RuntimeMethod::highestBulge_m(std::size_t body) const {
  const ServoObject& object = *std::ranges::find(scene_->objects, ids_[body], &ServoObject::id);
  return object.detail && object.detail->shading ? object.detail->shading->highestBulge_m() : 0;
}

void RuntimeMethod::adopt() {
  if (next_ && adoptScene(*next_, state_, tick_)) scene_ = std::move(next_);
}

void RuntimeMethod::place(Vec3 hip) {
  haptics::resetContact(state_.contact, hip);
  state_.supervision.attached = false;
  (void)step(hip);
}

Felt RuntimeMethod::tick(std::span<const Pose> poses, Vec3 hip) {
  adopt();
  for (std::size_t i = 0; i < state_.objects.count; ++i) {
    const auto id = std::ranges::find(ids_, state_.objects[i].id);
    const auto given = static_cast<std::size_t>(id - ids_.begin());
    const Body& body = state_.bodies[i];
    const bool moves = id != ids_.end() && !(poses[given] == poses_[given]);
    if (!moves && !body.moving) continue;
    const Pose previous = lastTestedPose(state_, body);
    state_.place(i, previous, moves ? poses[given] : Pose(body.current));
  }
  poses_.assign(poses.begin(), poses.end());
  return step(hip);
}

Felt RuntimeMethod::drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) {
  adopt();
  if (haveCome) {
    auto scene = std::make_unique<ServoScene>(*scene_);
    ++samples_;
    scene->kinematic.clear();
    for (const Pose& sample : samples) scene->kinematic.push_back({samples_, sample});
    next_ = std::move(scene);
    adopt();
  }
  return step(hip);
}

Felt RuntimeMethod::step(Vec3 hip) {
  const std::span<const Body> bodies = state_.allBodies();
  if (contactOnly_) return feelContact(bodies, hip);
  // The step keeps what its contact cost to itself: asked of the same core, on a copy of its state.
  ContactState copy = state_.contact;
  ContactCache cache;
  const ContactWork work = followContact(bodies, copy, hip, cache).work;
  const TelemetrySample sample = hapticStep(*scene_, state_, config_, {tick_++, 0, {hip, DeviceState::kReady}});
  // Shading turns the force; where the contact is it leaves as it is. A tissue that yields does not.
  const bool isOfContact = (shading_ && !tissue_) || sample.object == 0;
  const Vec3 ihip = isOfContact ? state_.contact.ihip : sample.ihip;
  return {sample.object != 0,
          ihip,
          sample.force.contact,
          work.triangles,
          sample.frictionState == FrictionState::kSliding,
          sample.force.written,
          state_.contact.reached < 1 ? std::optional(state_.contact.hip) : std::nullopt};
}

/// Of the step no more than the contact and its force.
Felt RuntimeMethod::feelContact(std::span<const Body> bodies, Vec3 hip) {
  if (!state_.features.detail) {
    const ContactResult contact = followContact(bodies, state_.contact, hip, state_.contactCache);
    return {contact.touching, contact.ihip, kSpring_N_per_m * (contact.ihip - hip), 0};
  }
  ForceResult felt;
  state_.estimate.hip = hip;
  followContact(bodies, state_.contact, hip, felt.contact, state_.contactCache);
  SurfaceForceModel surfaceForces(*scene_, state_, config_, felt);
  surfaceForces.addShading();
  surfaceForces.addTexture();
  surfaceForces.addSpringDamper();
  surfaceForces.addFriction();
  surfaceForces.writeResult();
  return {felt.contact.touching, state_.contact.ihip, felt.force.spring, 0};
}

}  // namespace haptics::eval
