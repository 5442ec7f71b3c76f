#include "haptic_server/scene/servo_scene_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/engine/tool/tool_contact.h"
#include "haptic_server/engine/tool/tool_shell.h"

namespace haptics {

namespace {

/// Stiffness and damping of a tool, where a body that it may push bears less.
void soften(ServoObject& tool, const BodyParts& body, const DeviceLimits& device) {
  if (!body.body) return;
  const double share = stableStiffnessShare(body.apparentMass_kg / device.hands, tool.stiffness_N_per_m,
                                            tool.damping_Ns_per_m, device.period_s);
  tool.stiffness_N_per_m *= share;
  tool.damping_Ns_per_m *= share;
  tool.grip_Nm_per_rad *= share;
}

[[nodiscard]] bool hasField(const ObjectAssets& assets) noexcept {
  return assets.textureField || assets.frictionField || assets.dynamicFrictionField || assets.stiffnessField ||
         assets.softnessField;
}

}  // namespace

ServoSceneBuilder::ServoSceneBuilder(MakePlan makePlan, const DeviceLimits& device)
    : makePlan_(std::move(makePlan)), device_(device) {}

std::unique_ptr<ServoScene> ServoSceneBuilder::make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan,
                                                    const OnMade& onMade) {
  const SceneVersion& version = sequencer.history()->version;
  std::vector<ServoObjectSource> objects;
  for (const auto& record : version.objects()) {
    objects.push_back({record, sequencer.assetsOf(record->id), sequencer.posedAt(record->id), false,
                       bakedDents(*record), sequencer.kinematicOf(record->id)});
    const auto driven = sequencer.drivenShapes().find(record->id);
    if (driven != sequencer.drivenShapes().end()) objects.back().shape = driven->second;
  }
  addPendingRemovals(objects, version, now_ns);
  Made made = build(std::move(objects), version.revision());
  const bool plans = makePlan_ && (!plan_ || (plan == Plan::kReplan && planIsOld(version.revision())));
  made.scene->plan = plans ? planFor(*made.scene) : plan_;
  if (onMade) onMade(*made.scene, made.sources);
  if (plans) {
    plan_ = made.scene->plan;
    planRevision_ = version.revision();
    bodiesMoved_ = false;
  }
  return keep(std::move(made));
}

std::unique_ptr<ServoScene> ServoSceneBuilder::keep(Made made) noexcept {
  parts_ = std::move(made.parts);
  std::erase_if(dentStates_, [this](const auto& entry) { return !parts_.contains(entry.first); });
  sources_ = std::move(made.sources);
  number_ = made.scene->number;
  revision_ = made.scene->revision;
  return std::move(made.scene);
}

const ServoObjectSource* ServoSceneBuilder::sourceBefore(ObjectId id) const {
  const auto at = std::ranges::lower_bound(sources_, id, {}, &ServoObjectSource::id);
  return at != sources_.end() && at->id() == id ? &*at : nullptr;
}

void ServoSceneBuilder::addPendingRemovals(std::vector<ServoObjectSource>& objects, const SceneVersion& version,
                                           std::uint64_t now_ns) {
  std::erase_if(pendingRemovals_, [now_ns](const PendingRemoval& l) { return l.until_ns <= now_ns; });
  for (const ServoObjectSource& object : sources_) {
    const auto sameObject = [&](const PendingRemoval& l) { return l.object.id() == object.id(); };
    if (!object.pendingRemoval && !version.find(object.id()) && std::ranges::none_of(pendingRemovals_, sameObject)) {
      pendingRemovals_.push_back({object, now_ns + kRemovalFade_ns});
      pendingRemovals_.back().object.pendingRemoval = true;
    }
  }
  const std::size_t room = kMaxServoObjects - objects.size();
  if (pendingRemovals_.size() > room)
    pendingRemovals_.erase(pendingRemovals_.begin(), pendingRemovals_.end() - static_cast<std::ptrdiff_t>(room));
  for (const PendingRemoval& pendingRemoval : pendingRemovals_) objects.push_back(pendingRemoval.object);
  std::ranges::sort(objects, {}, &ServoObjectSource::id);
}

ServoSceneBuilder::Made ServoSceneBuilder::build(std::vector<ServoObjectSource> objects, std::uint64_t revision) const {
  auto scene = std::make_unique<ServoScene>();
  scene->number = number_ + 1;
  scene->revision = revision;
  std::map<ObjectId, ObjectParts> made;
  EffectZones effects;
  for (const ServoObjectSource& source : objects) {
    if (!source.pendingRemoval) effects.add(*source.record);
  }
  for (const ServoObjectSource& source : objects) {
    const ObjectRecord& record = *source.record;
    const ObjectParts& parts = made[record.id] = partsOf(source, effects);
    const auto [stiffness, highestFactor] = stableStiffness(record.material, parts.detail.get());
    const auto [stiffness_N_per_m, damping_Ns_per_m] = stiffness;
    const auto& [body, apparentMass_kg, collision, tool] = parts.body;
    const double share = body ? stableStiffnessShare(apparentMass_kg / device_.hands, highestFactor * stiffness_N_per_m,
                                                     highestFactor * damping_Ns_per_m, device_.period_s)
                              : 1;
    const auto grasp =
        body ? graspSprings(*body, apparentMass_kg, share * stiffness_N_per_m, device_.period_s, device_.hands)
             : GraspSprings{};
    scene->objects.push_back(
        {.id = record.id,
         .surface = parts.surface,
         .pose = record.pose,
         .stiffness_N_per_m = std::max(share * stiffness_N_per_m, tool ? ToolCoupling::kMin : 0),
         .damping_Ns_per_m = share * damping_Ns_per_m,
         .pendingRemoval = source.pendingRemoval,
         .detail = parts.detail,
         .motion = body,
         .collision = collision,
         .tool = tool,
         .torsion_Nm_per_rad = tool ? std::max(ToolCoupling::kMin, std::min(record.motion->tool->torsion_Nm_per_rad,
                                                                            device_.stiffestTorsion_Nm_per_rad))
                                    : std::min(grasp.torsion_Nm_per_rad, device_.stiffestTorsion_Nm_per_rad),
         .grip_Nm_per_rad = tool && tool->jaws
                                ? std::max(ToolCoupling::kMin, std::min(record.motion->tool->jaws->grip_Nm_per_rad,
                                                                        device_.stiffestGrip_Nm_per_rad))
                                : 0,
         .poseRevision = source.poseRevision,
         .tissue = parts.tissue,
         .baked = source.baked,
         .highestFactor = highestFactor,
         .graspDamping_Ns_per_m = std::min(grasp.damping_Ns_per_m, device_.maxDamping_Ns_per_m)});
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto& fields = made.at(objects[i].id()).effects;
    if (objects[i].pendingRemoval) continue;
    for (std::size_t number = 0; number < fields.size(); ++number)
      scene->effects.push_back({i, number, fields[number]});
  }
  const auto isDriven = [](const ServoObjectSource& source) { return source.kinematic.number != 0; };
  if (std::ranges::any_of(objects, isDriven)) {
    for (const ServoObjectSource& source : objects) scene->kinematic.push_back(source.kinematic);
  }
  double spacing_m = std::numeric_limits<double>::infinity();  // of the tool with the narrowest
  for (std::size_t i = 0; i < objects.size(); ++i) {
    ServoObject& tool = scene->objects[i];
    if (tool.tool == nullptr || tool.pendingRemoval) continue;
    spacing_m = std::min(spacing_m, objects[i].record->motion->tool->spacing_m);
    for (const auto& [id, parts] : made) soften(tool, parts.body, device_);
  }
  const bool anyTool = std::isfinite(spacing_m);
  const auto isReshaped = [](const ServoObjectSource& source) { return source.shape.number != 0; };
  if (!anyTool && std::ranges::any_of(objects, isReshaped)) {
    for (const ServoObjectSource& source : objects) scene->shapes.push_back(made.at(source.id()).shape);
  }
  if (anyTool) addSharpPoints(*scene, made, spacing_m);
  return {std::move(scene), std::move(made), std::move(objects)};
}

/// Where the stiffness varies it is the device's limit at the places that would pass it, and as asked for elsewhere.
/// Damping has the same ratio to it everywhere, and so is less everywhere where it would pass the limit anywhere.
ServoSceneBuilder::StableStiffness ServoSceneBuilder::stableStiffness(const Material& material,
                                                                      const SurfaceDetail* detail) const {
  double stiffness_N_per_m = material.stiffness_N_per_m, highestFactor = 1;
  if (detail && detail->stiffness) {
    highestFactor = std::min(detail->stiffness->highest(), device_.stiffest_N_per_m / stiffness_N_per_m);
  } else {
    stiffness_N_per_m = std::min(stiffness_N_per_m, device_.stiffest_N_per_m);
  }
  return {{stiffness_N_per_m, std::min(material.damping_Ns_per_m, device_.maxDamping_Ns_per_m / highestFactor)},
          highestFactor};
}

/// @param last  Of the last scene: none where the surface is another one.
KinematicShape ServoSceneBuilder::shapeOf(const ServoObjectSource& source, const CollisionMesh& surface,
                                          const KinematicShape& last) const {
  KinematicShape shape;
  const auto& samples = source.shape.samples;
  if (source.shape.number == 0) return shape;
  shape.number = source.shape.number;
  shape.first = source.shape.first();
  shape.first_s = kFirstSample_s;
  std::ranges::transform(samples, shape.samples.fromOldest.end() - static_cast<std::ptrdiff_t>(samples.size()),
                         [](const auto& sample) { return sample->vertices; });
  const std::vector<Vec3f>& newest = *samples.back()->vertices;
  const std::vector<Vec3f>& before = *samples[samples.size() - 2]->vertices;
  double way2 = 0;
  for (std::size_t v = 0; v < newest.size(); ++v)
    way2 = std::max(way2, squaredLength(Vec3(newest[v]) - Vec3(before[v])));
  shape.way_m = std::sqrt(way2);
  if (last.number != 0 && last.number >= shape.first) {
    shape.memory = last.memory;
  } else {
    for (int hand = 0; hand < device_.hands; ++hand)
      shape.memory[static_cast<std::size_t>(hand)] = std::make_shared<ShapeMemory>(surface, newest.size());
  }
  return shape;
}

/// Making a part takes milliseconds, and more of a large mesh.
ServoSceneBuilder::ObjectParts ServoSceneBuilder::partsOf(const ServoObjectSource& source,
                                                          const EffectZones& effects) const {
  const ObjectRecord& record = *source.record;
  const ObjectAssets& assets = source.assets;
  const auto& [softness, lattice, residue] = record.deformation;
  const bool isDeformed = lattice || residue;
  const bool isDriven = source.shape.number != 0;

  const ServoObjectSource* const before = sourceBefore(record.id);
  ObjectParts parts;
  if (before != nullptr) parts = parts_.at(record.id);
  const ObjectRecord* const was = before != nullptr ? before->record.get() : nullptr;
  const bool sameMesh = was != nullptr && was->mesh == record.mesh;
  const bool sameSurface = sameMesh && was->deformation.lattice == lattice && was->deformation.residue == residue;

  if (!sameSurface) {
    if (!isDeformed) {
      parts.surface = assets.mesh->surface;
    } else if (assets.derived.shape) {
      parts.surface = assets.derived.shape;
    } else {  // most of the last shape stays where it was when a dent is added
      parts.surface = assets.surfaceAtRest(record.deformation, sameMesh ? parts.surface.get() : nullptr);
    }
  }
  parts.shape = shapeOf(source, *parts.surface, sameSurface ? parts.shape : KinematicShape{});
  const SurfaceProperties& properties = record.material.surface;
  const bool sameMaterial = before != nullptr && isDriven == (before->shape.number != 0);
  if (!sameSurface || was->material.surface != properties || (!isDeformed && !sameMaterial && hasField(assets))) {
    const auto scaleOf = [](const auto& asset) { return asset ? asset->values : nullptr; };
    DetailFields fields{.texture = assets.textureField,
                        .friction = assets.frictionField,
                        .frictionScale = scaleOf(assets.frictionScale),
                        .dynamicFriction = assets.dynamicFrictionField,
                        .dynamicFrictionScale = scaleOf(assets.dynamicFrictionScale),
                        .stiffness = {assets.stiffnessField, scaleOf(assets.stiffnessScale)},
                        .softness = {assets.softnessField, scaleOf(assets.softnessScale)}};
    if (isDeformed || isDriven) fields.material = {assets.mesh, &assets.mesh->mesh->vertices};
    const bool sameShading = sameSurface && parts.detail && was->material.surface.shading == properties.shading;
    const auto normals = sameShading ? parts.detail->shading : assets.derived.normals;
    parts.detail = makeSurfaceDetail(*parts.surface, properties, fields, normals);
  }
  if (!sameMesh || was->motion != record.motion) {
    parts.body = {};
    if (record.motion) {
      if (const auto made = bodyPartsOf(record, assets); *made)
        parts.body = **made;  // the sequencer refuses what makes none
    }
  }
  if (was == nullptr || was->deformation.softness != softness)
    parts.tissue = softness ? std::make_shared<const SoftTissue>(tissueOf(*softness)) : nullptr;
  const bool sameBody = sameMesh && was->motion == record.motion;
  if (!sameBody) parts.effects.clear();
  if (!source.pendingRemoval) {
    const std::vector<EffectShare> shares = effects.sharesOf(record.id, device_);
    const bool sameEffects = was == &record || (was != nullptr && was->effects == record.effects);
    if (!sameBody || !sameEffects || parts.shares != shares) parts.effects = effectsOf(record, parts, effects);
    parts.shares = shares;
  }
  if (!sameSurface) {
    parts.sharp = nullptr;
    parts.spacing_m = 0;
  }
  return parts;
}

/// Those that are felt as before are the same ones.
std::vector<std::shared_ptr<const EffectField>> ServoSceneBuilder::effectsOf(const ObjectRecord& record,
                                                                             const ObjectParts& parts,
                                                                             const EffectZones& all) const {
  const bool moves = parts.body.body != nullptr;
  const auto apparentMass_kg = moves ? std::optional(parts.body.apparentMass_kg) : std::nullopt;
  std::vector<std::shared_ptr<const EffectField>> effects;
  for (const Effect& effect : stableEffects(record, all, apparentMass_kg, device_)) {
    const std::size_t i = effects.size();
    const bool isKept = i < parts.effects.size() && parts.effects[i]->effect() == effect;
    effects.push_back(isKept ? parts.effects[i] : std::make_shared<const EffectField>(effect, device_.period_s));
  }
  return effects;
}

/// Sharp points of all objects that a tool may touch.
void ServoSceneBuilder::addSharpPoints(ServoScene& scene, std::map<ObjectId, ObjectParts>& parts,
                                       double spacing_m) const {
  for (ServoObject& object : scene.objects) {
    if (object.tool) continue;
    ObjectParts& own = parts[object.id];
    if (own.spacing_m != spacing_m)
      own.sharp = std::make_shared<const std::vector<Vec3>>(sharpPoints(*own.surface, spacing_m, kMaxToolPoints));
    own.spacing_m = spacing_m;
    object.sharp = own.sharp;
  }
}

/// The shape counts as another one where mesh or lattice were edited, or a residue that is not the builder's.
BakedDents ServoSceneBuilder::bakedDents(const ObjectRecord& record) const {
  const ServoObjectSource* const before = sourceBefore(record.id);
  const auto dents = dentStates_.find(record.id);
  const auto& [softness, lattice, residue] = record.deformation;
  const bool isOurs = dents != dentStates_.end() && residue == dents->second.residue;
  const bool sameShape = before != nullptr && before->record->mesh == record.mesh &&
                         before->record->deformation.lattice == lattice &&
                         (before->record->deformation.residue == residue || isOurs);
  BakedDents baked = before != nullptr ? before->baked : BakedDents{};
  if (!sameShape) ++baked.shape;
  if (dents == dentStates_.end()) return baked;
  if (isOurs) baked.upTo = std::max(baked.upTo, dents->second.upTo);
  baked.releasedUpTo = std::max(baked.releasedUpTo, dents->second.releasedUpTo);
  return baked;
}

void ServoSceneBuilder::setBakedDents(ObjectId object, const std::optional<ContentHash>& residue, std::uint64_t upTo) {
  dentStates_[object].residue = residue;
  dentStates_[object].upTo = upTo;
}

std::shared_ptr<const ExplorationPlan> ServoSceneBuilder::planFor(ServoScene scene) const {
  std::erase_if(scene.objects, [this](const ServoObject& object) {
    const auto body = bodies_.find(object.id);
    const bool hasLeft = object.motion && body != bodies_.end() && isStopped(body->second.condition);
    return object.pendingRemoval || object.tool || hasLeft;
  });
  for (ServoObject& object : scene.objects) {
    const auto body = bodies_.find(object.id);
    if (object.motion && body != bodies_.end()) object.pose = body->second.pose;
  }
  return makePlan_(scene);
}

void ServoSceneBuilder::follow(const MotionState& motion) {
  const auto isHeld = [this](const BodyState& body) {
    const auto known = parts_.find(body.object);
    return known != parts_.end() && known->second.body.tool != nullptr;
  };
  const bool allRest = std::ranges::all_of(
      motion.bodies(), [&](const BodyState& body) { return body.condition != BodyCondition::kAwake || isHeld(body); });
  if (!makePlan_ || !allRest) return;
  for (const BodyState& body : motion.bodies()) {
    if (isHeld(body)) continue;
    const auto planned = bodies_.find(body.object);
    bodiesMoved_ = bodiesMoved_ || planned == bodies_.end() || !(planned->second == body);
  }
  bodies_.clear();
  for (const BodyState& body : motion.bodies()) {
    if (!isHeld(body)) bodies_[body.object] = body;
  }
}

std::optional<std::uint64_t> ServoSceneBuilder::nextDeparture_ns() const {
  if (pendingRemovals_.empty()) return std::nullopt;
  return pendingRemovals_.front().until_ns;
}

}  // namespace haptics
