#include "haptic_server/scene/servo_scene_maker.h"

#include <algorithm>
#include <utility>

namespace haptics {

ServoSceneMaker::ServoSceneMaker(MakePlan makePlan, double stiffest_N_per_m)
    : makePlan_(std::move(makePlan)), stiffest_N_per_m_(stiffest_N_per_m) {}

std::unique_ptr<const ServoScene> ServoSceneMaker::make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan) {
  const SceneVersion& version = sequencer.history()->version;
  auto scene = std::make_unique<ServoScene>();
  scene->revision = revision_ = version.revision();
  std::map<ObjectId, Detailed> detailed;
  for (const auto& record : version.objects()) {
    const Detailed& known = detailed[record->id] = detailOf(*record, sequencer.assetsOf(record->id));
    scene->objects.push_back({.id = record->id,
                              .surface = known.surface,
                              .pose = record->pose,
                              .stiffness_N_per_m = std::min(record->material.stiffness_N_per_m, stiffest_N_per_m_),
                              .damping_Ns_per_m = record->material.damping_Ns_per_m,
                              .detail = known.detail});
  }
  detailed_ = std::move(detailed);
  if (makePlan_ && (!plan_ || (plan == Plan::kOfThisOne && planIsOld()))) {
    plan_ = makePlan_(*scene);
    planRevision_ = revision_;
  }
  scene->plan = plan_;

  std::erase_if(leaving_, [now_ns](const Leaving& l) { return l.until_ns <= now_ns; });
  for (const ServoObject& object : present_) {
    if (!version.find(object.id)) {
      leaving_.push_back({object, now_ns + kLeaving_ns});
      leaving_.back().object.leaving = true;
    }
  }
  present_ = scene->objects;

  const std::size_t room = kMaxServoObjects - scene->objects.size();
  if (leaving_.size() > room) leaving_.erase(leaving_.begin(), leaving_.end() - static_cast<std::ptrdiff_t>(room));
  for (const Leaving& leaving : leaving_) scene->objects.push_back(leaving.object);
  std::ranges::sort(scene->objects, {}, &ServoObject::id);
  return scene;
}

/// Making a detail takes milliseconds, and normals of a large mesh more: what did not change is kept.
ServoSceneMaker::Detailed ServoSceneMaker::detailOf(const ObjectRecord& record, const ObjectAssets& assets) const {
  const SurfaceProperties& properties = record.material.surface;
  const auto known = detailed_.find(record.id);
  const bool sameSurface = known != detailed_.end() && known->second.surface == assets.mesh->surface;
  if (sameSurface && known->second.properties == properties) return known->second;

  DetailFields fields{.texture = assets.textureField, .friction = assets.frictionField, .frictionScale = {}};
  if (assets.frictionScale) fields.frictionScale = {assets.frictionScale, &assets.frictionScale->values};
  std::shared_ptr<const ShadingNormals> normals;
  if (sameSurface && known->second.detail && known->second.properties.shading == properties.shading) {
    normals = known->second.detail->shading;
  }
  return {assets.mesh->surface, properties,
          makeSurfaceDetail(*assets.mesh->surface, properties, fields, std::move(normals))};
}

bool ServoSceneMaker::planIsOld() const noexcept { return makePlan_ && planRevision_ != revision_; }

std::optional<std::uint64_t> ServoSceneMaker::nextDeparture_ns() const {
  if (leaving_.empty()) return std::nullopt;
  return leaving_.front().until_ns;
}

}  // namespace haptics
