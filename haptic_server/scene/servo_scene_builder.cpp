#include "haptic_server/scene/servo_scene_builder.h"

#include <algorithm>
#include <utility>

#include "haptic_server/geometry/spaced_points.h"
#include "haptic_server/motion/coupling.h"
#include "haptic_server/tool/tool_shell.h"

namespace haptics {

namespace {

/// Stiffness and damping of a tool, where a body that it may push bears less.
void soften(ServoObject& tool, const BodyParts& body, const DeviceLimits& device) {
  if (!body.body) return;
  const double share = stableStiffnessShare(body.apparentMass_kg / device.hands, tool.stiffness_N_per_m,
                                            tool.damping_Ns_per_m, device.period_s);
  tool.stiffness_N_per_m *= share;
  tool.damping_Ns_per_m *= share;
}

}  // namespace

ServoSceneBuilder::ServoSceneBuilder(MakePlan makePlan, const DeviceLimits& device)
    : makePlan_(std::move(makePlan)), device_(device) {}

std::unique_ptr<const ServoScene> ServoSceneBuilder::make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan) {
  const SceneVersion& version = sequencer.history()->version;
  std::vector<ServoObjectSource> objects;
  for (const auto& record : version.objects()) {
    objects.push_back({record, sequencer.assetsOf(record->id), sequencer.posedAt(record->id)});
  }
  addPendingRemovals(objects, version, now_ns);
  auto scene = make(std::move(objects), version.revision());
  if (makePlan_ && (!plan_ || (plan == Plan::kOfThisOne && planIsOld()))) {
    plan_ = planFor(*scene);
    planRevision_ = revision_;
    bodiesMoved_ = false;
  }
  scene->plan = plan_;
  return scene;
}

void ServoSceneBuilder::addPendingRemovals(std::vector<ServoObjectSource>& objects, const SceneVersion& version,
                                           std::uint64_t now_ns) {
  std::erase_if(pendingRemovals_, [now_ns](const PendingRemoval& l) { return l.until_ns <= now_ns; });
  for (const ServoObjectSource& object : parts_) {
    const auto sameObject = [&](const PendingRemoval& l) { return l.object.record->id == object.record->id; };
    if (!object.pendingRemoval && !version.find(object.record->id) &&
        std::ranges::none_of(pendingRemovals_, sameObject)) {
      pendingRemovals_.push_back({object, now_ns + kRemovalFade_ns});
      pendingRemovals_.back().object.pendingRemoval = true;
    }
  }
  const std::size_t room = kMaxServoObjects - objects.size();
  if (pendingRemovals_.size() > room)
    pendingRemovals_.erase(pendingRemovals_.begin(), pendingRemovals_.end() - static_cast<std::ptrdiff_t>(room));
  for (const PendingRemoval& pendingRemoval : pendingRemovals_) objects.push_back(pendingRemoval.object);
  std::ranges::sort(objects, {}, [](const ServoObjectSource& object) { return object.record->id; });
}

std::unique_ptr<ServoScene> ServoSceneBuilder::make(std::vector<ServoObjectSource> objects, std::uint64_t revision) {
  auto scene = std::make_unique<ServoScene>();
  scene->number = ++number_;
  scene->revision = revision_ = revision;
  std::map<ObjectId, CachedObject> cached;
  for (const auto& [record, assets, poseRevision, pendingRemoval] : objects) {
    const auto last = cachedObjects_.find(record->id);
    const CachedObject* before = last == cachedObjects_.end() ? nullptr : &last->second;
    CachedObject& known = cached[record->id] = detailOf(*record, assets, before);
    addBody(known, *record, assets, before);
    addTissue(known, *record, before);
    addBakedDents(known, record->id, before);
    const auto [stiffness, highestFactor] = stableStiffness(record->material, known.detail.get());
    const auto [stiffness_N_per_m, damping_Ns_per_m] = stiffness;
    const auto& [body, apparentMass_kg, collision, tool] = known.body;
    const double share = body ? stableStiffnessShare(apparentMass_kg / device_.hands, highestFactor * stiffness_N_per_m,
                                                     highestFactor * damping_Ns_per_m, device_.period_s)
                              : 1;
    scene->objects.push_back({.id = record->id,
                              .surface = known.surface,
                              .pose = record->pose,
                              .stiffness_N_per_m = share * stiffness_N_per_m,
                              .damping_Ns_per_m = share * damping_Ns_per_m,
                              .pendingRemoval = pendingRemoval,
                              .detail = known.detail,
                              .motion = body,
                              .collision = collision,
                              .tool = tool,
                              .torsion_Nm_per_rad = tool ? stableTorsion_Nm_per_rad(*record->motion->tool) : 0,
                              .poseRevision = poseRevision,
                              .tissue = known.tissue,
                              .baked = known.baked,
                              .highestFactor = highestFactor});
  }
  const auto tool = std::ranges::find_if(
      scene->objects, [](const ServoObject& object) { return object.tool != nullptr && !object.pendingRemoval; });
  if (tool != scene->objects.end()) {
    addSharpPoints(*scene, cached, cached[tool->id].motion->tool->spacing_m);
    for (const auto& [id, known] : cached) soften(*tool, known.body, device_);
  }
  cachedObjects_ = std::move(cached);
  std::erase_if(dentStates_, [this](const auto& entry) { return !cachedObjects_.contains(entry.first); });
  parts_ = std::move(objects);
  return scene;
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

double ServoSceneBuilder::stableTorsion_Nm_per_rad(const ToolProperties& tool) const {
  return std::min(tool.torsion_Nm_per_rad, device_.stiffestTorsion_Nm_per_rad);
}

/// Making a detail takes milliseconds, and normals of a large mesh more: what did not change is kept.
ServoSceneBuilder::CachedObject ServoSceneBuilder::detailOf(const ObjectRecord& record, const ObjectAssets& assets,
                                                            const CachedObject* before) const {
  const SurfaceProperties& properties = record.material.surface;
  const std::shared_ptr<const CollisionMesh> surface = shapeOf(record, assets, before);
  const bool sameSurface = before && before->surface == surface;
  if (sameSurface && before->properties == properties) return *before;

  DetailFields fields{.texture = assets.textureField, .friction = assets.frictionField, .frictionScale = {}};
  const auto scaleOf = [](const auto& asset) { return asset ? asset->values : nullptr; };
  fields.frictionScale = scaleOf(assets.frictionScale);
  fields.dynamicFriction = assets.dynamicFrictionField;
  fields.dynamicFrictionScale = scaleOf(assets.dynamicFrictionScale);
  fields.stiffness = {assets.stiffnessField, scaleOf(assets.stiffnessScale)};
  fields.softness = {assets.softnessField, scaleOf(assets.softnessScale)};
  if (surface != assets.mesh->surface) fields.material = {assets.mesh, &assets.mesh->mesh->vertices};
  const bool sameShading = sameSurface && before->detail && before->properties.shading == properties.shading;
  const auto& normals = sameShading ? before->detail->shading : assets.derived.normals;
  CachedObject made{surface, properties, makeSurfaceDetail(*surface, properties, fields, normals)};
  made.atRest = assets.mesh->surface;
  return made;
}

/// The mesh's surface, or as lattice and residue have it; the last scene's where none of them has changed.
std::shared_ptr<const CollisionMesh> ServoSceneBuilder::shapeOf(const ObjectRecord& record, const ObjectAssets& assets,
                                                                const CachedObject* before) const {
  const auto& [softness, lattice, residue] = record.deformation;
  if (!lattice && !residue) return assets.mesh->surface;
  const bool sameMesh = before && before->atRest == assets.mesh->surface;
  if (sameMesh && before->deformation.lattice == lattice && before->deformation.residue == residue) {
    return before->surface;
  }
  if (assets.derived.shape) return assets.derived.shape;
  // Most of the last shape stays where it was when a dent is added.
  return refitCollisionMesh(sameMesh ? *before->surface : *assets.mesh->surface,
                            assets.shapeAtRest(record.deformation));
}

/// Of all that the tool may meet.
void ServoSceneBuilder::addSharpPoints(ServoScene& scene, std::map<ObjectId, CachedObject>& cached,
                                       double spacing_m) const {
  for (ServoObject& object : scene.objects) {
    if (object.tool) continue;
    CachedObject& known = cached[object.id];
    const auto last = cachedObjects_.find(object.id);
    if (last != cachedObjects_.end() && last->second.surface == known.surface && last->second.spacing_m == spacing_m) {
      known.sharp = last->second.sharp;
    } else {
      known.sharp = std::make_shared<const std::vector<Vec3>>(sharpPoints(*known.surface, spacing_m, kMaxToolPoints));
    }
    known.spacing_m = spacing_m;
    object.sharp = known.sharp;
  }
}

void ServoSceneBuilder::addTissue(CachedObject& cached, const ObjectRecord& record, const CachedObject* before) const {
  const auto& softness = record.deformation.softness;
  const bool same = before && before->deformation.softness == softness;
  cached.deformation = record.deformation;
  cached.tissue = nullptr;
  if (softness) cached.tissue = same ? before->tissue : std::make_shared<const SoftTissue>(tissueOf(*softness));
}

/// The shape counts as another one where mesh or lattice were edited, or a residue that is not the builder's.
void ServoSceneBuilder::addBakedDents(CachedObject& cached, ObjectId object, const CachedObject* before) const {
  const auto dents = dentStates_.find(object);
  const auto& [softness, lattice, residue] = cached.deformation;
  const bool isOurs = dents != dentStates_.end() && residue == dents->second.residue;
  const bool sameShape = before && before->atRest == cached.atRest && before->deformation.lattice == lattice &&
                         (before->deformation.residue == residue || isOurs);
  cached.baked = before ? before->baked : BakedDents{};
  if (!sameShape) ++cached.baked.shape;
  if (dents == dentStates_.end()) return;
  if (isOurs) cached.baked.upTo = std::max(cached.baked.upTo, dents->second.upTo);
  cached.baked.releasedUpTo = std::max(cached.baked.releasedUpTo, dents->second.releasedUpTo);
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

void ServoSceneBuilder::addBody(CachedObject& cached, const ObjectRecord& record, const ObjectAssets& assets,
                                const CachedObject* before) const {
  cached.motion = record.motion;
  cached.body = {};
  if (!record.motion) return;
  if (!assets.derived.body && before && before->surface == cached.surface && before->motion == record.motion) {
    cached.body = before->body;
  } else if (const auto made = bodyPartsOf(record, assets); *made) {  // the sequencer refuses what makes none
    cached.body = **made;
  }
}

void ServoSceneBuilder::follow(const MotionState& motion) {
  const auto isHeld = [this](const BodyState& body) {
    const auto known = cachedObjects_.find(body.object);
    return known != cachedObjects_.end() && known->second.body.tool != nullptr;
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
