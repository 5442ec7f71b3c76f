#include "haptic_server/scene/servo_scene_maker.h"

#include <algorithm>
#include <utility>

#include "haptic_server/motion/coupling.h"

namespace haptics {

ServoSceneMaker::ServoSceneMaker(MakePlan makePlan, const DeviceLimits& device)
    : makePlan_(std::move(makePlan)), device_(device) {}

std::unique_ptr<const ServoScene> ServoSceneMaker::make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan) {
  const SceneVersion& version = sequencer.history()->version;
  std::vector<ServoObjectParts> objects;
  for (const auto& record : version.objects()) {
    objects.push_back({record, sequencer.assetsOf(record->id), sequencer.posedAt(record->id)});
  }
  addLeaving(objects, version, now_ns);
  auto scene = make(std::move(objects), version.revision());
  if (makePlan_ && (!plan_ || (plan == Plan::kOfThisOne && planIsOld()))) {
    plan_ = planFor(*scene);
    planRevision_ = revision_;
    bodiesMoved_ = false;
  }
  scene->plan = plan_;
  return scene;
}

void ServoSceneMaker::addLeaving(std::vector<ServoObjectParts>& objects, const SceneVersion& version,
                                 std::uint64_t now_ns) {
  std::erase_if(leaving_, [now_ns](const Leaving& l) { return l.until_ns <= now_ns; });
  for (const ServoObjectParts& object : parts_) {
    const auto sameObject = [&](const Leaving& l) { return l.object.record->id == object.record->id; };
    if (!object.leaving && !version.find(object.record->id) && std::ranges::none_of(leaving_, sameObject)) {
      leaving_.push_back({object, now_ns + kLeaving_ns});
      leaving_.back().object.leaving = true;
    }
  }
  const std::size_t room = kMaxServoObjects - objects.size();
  if (leaving_.size() > room) leaving_.erase(leaving_.begin(), leaving_.end() - static_cast<std::ptrdiff_t>(room));
  for (const Leaving& leaving : leaving_) objects.push_back(leaving.object);
  std::ranges::sort(objects, {}, [](const ServoObjectParts& object) { return object.record->id; });
}

std::unique_ptr<ServoScene> ServoSceneMaker::make(std::vector<ServoObjectParts> objects, std::uint64_t revision) {
  auto scene = std::make_unique<ServoScene>();
  scene->number = ++number_;
  scene->revision = revision_ = revision;
  std::map<ObjectId, Detailed> detailed;
  for (const auto& [record, assets, poseRevision, leaving] : objects) {
    Detailed& known = detailed[record->id] = detailOf(*record, assets);
    addBody(known, *record, assets);
    addTissue(known, *record);
    addTakenDents(known, record->id);
    const auto [stiffness, highestFactor] = bearableStiffness(record->material, known.detail.get());
    const auto [stiffness_N_per_m, damping_Ns_per_m] = stiffness;
    const double share = known.body ? bearableShare(known.feltMass_kg, highestFactor * stiffness_N_per_m,
                                                    highestFactor * damping_Ns_per_m, device_.period_s)
                                    : 1;
    scene->objects.push_back({.id = record->id,
                              .surface = known.surface,
                              .pose = record->pose,
                              .stiffness_N_per_m = share * stiffness_N_per_m,
                              .damping_Ns_per_m = share * damping_Ns_per_m,
                              .leaving = leaving,
                              .detail = known.detail,
                              .motion = known.body,
                              .poseRevision = poseRevision,
                              .tissue = known.tissue,
                              .taken = known.taken,
                              .highestFactor = highestFactor});
  }
  detailed_ = std::move(detailed);
  std::erase_if(told_, [this](const auto& entry) { return !detailed_.contains(entry.first); });
  parts_ = std::move(objects);
  return scene;
}

/// Where the stiffness varies it is the device's limit at the places that would pass it, and as asked for elsewhere; damping
/// has the same ratio to it everywhere, and so is less everywhere where it would pass the limit anywhere.
ServoSceneMaker::BearableStiffness ServoSceneMaker::bearableStiffness(const Material& material,
                                                                      const SurfaceDetail* detail) const {
  double stiffness_N_per_m = material.stiffness_N_per_m, highestFactor = 1;
  if (detail && detail->stiffness) {
    highestFactor = std::min(detail->stiffness->highest(), device_.stiffest_N_per_m / stiffness_N_per_m);
  } else {
    stiffness_N_per_m = std::min(stiffness_N_per_m, device_.stiffest_N_per_m);
  }
  return {{stiffness_N_per_m, std::min(material.damping_Ns_per_m, device_.mostDamping_Ns_per_m / highestFactor)},
          highestFactor};
}

/// Making a detail takes milliseconds, and normals of a large mesh more: what did not change is kept.
ServoSceneMaker::Detailed ServoSceneMaker::detailOf(const ObjectRecord& record, const ObjectAssets& assets) const {
  const SurfaceProperties& properties = record.material.surface;
  const auto known = detailed_.find(record.id);
  const std::shared_ptr<const Surface> surface = shapeOf(record, assets);
  const bool sameSurface = known != detailed_.end() && known->second.surface == surface;
  if (sameSurface && known->second.properties == properties) return known->second;

  DetailFields fields{.texture = assets.textureField, .friction = assets.frictionField, .frictionScale = {}};
  const auto scaleOf = [](const auto& asset) { return asset ? asset->values : nullptr; };
  fields.frictionScale = scaleOf(assets.frictionScale);
  fields.dynamicFriction = assets.dynamicFrictionField;
  fields.dynamicFrictionScale = scaleOf(assets.dynamicFrictionScale);
  fields.stiffness = {assets.stiffnessField, scaleOf(assets.stiffnessScale)};
  fields.softness = {assets.softnessField, scaleOf(assets.softnessScale)};
  if (surface != assets.mesh->surface) fields.material = {assets.mesh, &assets.mesh->mesh->vertices};
  std::shared_ptr<const ShadingNormals> normals;
  if (sameSurface && known->second.detail && known->second.properties.shading == properties.shading) {
    normals = known->second.detail->shading;
  } else {
    normals = assets.derived.normals;
  }
  Detailed made{surface, properties, makeSurfaceDetail(*surface, properties, fields, std::move(normals))};
  made.atRest = assets.mesh->surface;
  return made;
}

/// The mesh's surface, or as lattice and residue have it; the last scene's where none of them has changed.
std::shared_ptr<const Surface> ServoSceneMaker::shapeOf(const ObjectRecord& record, const ObjectAssets& assets) const {
  const auto& [softness, lattice, residue] = record.deformation;
  if (!lattice && !residue) return assets.mesh->surface;
  const auto known = detailed_.find(record.id);
  const bool sameMesh = known != detailed_.end() && known->second.atRest == assets.mesh->surface;
  if (sameMesh && known->second.deformation.lattice == lattice && known->second.deformation.residue == residue) {
    return known->second.surface;
  }
  if (assets.derived.shape) return assets.derived.shape;
  // Of the last shape most is left where it was by a dent, and by another one.
  const Surface& from = sameMesh ? *known->second.surface : *assets.mesh->surface;
  return refitSurface(from, assets.shapeAtRest(record.deformation));
}

void ServoSceneMaker::addTissue(Detailed& detailed, const ObjectRecord& record) const {
  detailed.deformation = record.deformation;
  detailed.tissue = nullptr;
  if (!record.deformation.softness) return;
  const auto known = detailed_.find(record.id);
  const bool same = known != detailed_.end() && known->second.deformation.softness == record.deformation.softness;
  detailed.tissue =
      same ? known->second.tissue : std::make_shared<const SoftTissue>(tissueOf(*record.deformation.softness));
}

/// The shape counts as another one where mesh or lattice were edited, or a residue that is not the builder's.
void ServoSceneMaker::addTakenDents(Detailed& detailed, ObjectId object) const {
  const auto known = detailed_.find(object);
  const auto told = told_.find(object);
  const DeformationProperties before = known == detailed_.end() ? DeformationProperties{} : known->second.deformation;
  detailed.taken = known == detailed_.end() ? TakenDents{} : known->second.taken;
  const std::optional<ContentHash>& residue = detailed.deformation.residue;
  const bool ours = told != told_.end() && residue == told->second.residue;
  const bool sameMesh = known != detailed_.end() && known->second.atRest == detailed.atRest;
  if (!sameMesh || before.lattice != detailed.deformation.lattice || (before.residue != residue && !ours)) {
    ++detailed.taken.shape;
  }
  if (told == told_.end()) return;
  if (ours) detailed.taken.upTo = std::max(detailed.taken.upTo, told->second.upTo);
  detailed.taken.loosenedUpTo = std::max(detailed.taken.loosenedUpTo, told->second.loosenedUpTo);
}

void ServoSceneMaker::takeDents(ObjectId object, const std::optional<ContentHash>& residue, std::uint64_t upTo) {
  told_[object].residue = residue;
  told_[object].upTo = upTo;
}

void ServoSceneMaker::loosenDents(ObjectId object, std::uint64_t upTo) { told_[object].loosenedUpTo = upTo; }

std::shared_ptr<const ExplorationPlan> ServoSceneMaker::planFor(ServoScene scene) const {
  std::erase_if(scene.objects, [](const ServoObject& object) { return object.leaving; });
  for (ServoObject& object : scene.objects) {
    const auto body = bodies_.find(object.id);
    if (object.motion && body != bodies_.end()) object.pose = body->second;
  }
  return makePlan_(scene);
}

void ServoSceneMaker::addBody(Detailed& detailed, const ObjectRecord& record, const ObjectAssets& assets) const {
  detailed.motion = record.motion;
  detailed.body = nullptr;
  if (!record.motion) return;
  if (const auto& made = assets.derived.body) {
    if (!*made) return;  // the sequencer refuses what makes no body
    detailed.body = (*made)->body;
    detailed.feltMass_kg = (*made)->feltMass_kg;
    return;
  }
  const auto known = detailed_.find(record.id);
  if (known != detailed_.end() && known->second.surface == detailed.surface && known->second.motion == record.motion) {
    detailed.body = known->second.body;
    detailed.feltMass_kg = known->second.feltMass_kg;
    return;
  }
  const auto made = feltBodyOf(record, assets);
  if (!*made) return;
  detailed.body = (*made)->body;
  detailed.feltMass_kg = (*made)->feltMass_kg;
}

bool ServoSceneMaker::planIsOld() const noexcept { return makePlan_ && (planRevision_ != revision_ || bodiesMoved_); }

void ServoSceneMaker::follow(const MotionState& motion) {
  const bool allRest = std::ranges::all_of(
      motion.bodies(), [](const BodyState& body) { return body.condition != BodyCondition::kAwake; });
  if (!makePlan_ || !allRest) return;
  for (const BodyState& body : motion.bodies()) {
    const auto planned = bodies_.find(body.object);
    bodiesMoved_ = bodiesMoved_ || planned == bodies_.end() || !(planned->second == body.pose);
  }
  bodies_.clear();
  for (const BodyState& body : motion.bodies()) bodies_[body.object] = body.pose;
}

std::optional<std::uint64_t> ServoSceneMaker::nextDeparture_ns() const {
  if (leaving_.empty()) return std::nullopt;
  return leaving_.front().until_ns;
}

}  // namespace haptics
