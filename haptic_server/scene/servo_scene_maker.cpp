#include "haptic_server/scene/servo_scene_maker.h"

#include <algorithm>
#include <utility>

namespace haptics {

ServoSceneMaker::ServoSceneMaker(MakePlan makePlan) : makePlan_(std::move(makePlan)) {}

std::unique_ptr<const ServoScene> ServoSceneMaker::make(const Sequencer& sequencer, std::uint64_t now_ns, Plan plan) {
  const SceneVersion& version = sequencer.history()->version;
  auto scene = std::make_unique<ServoScene>();
  scene->revision = revision_ = version.revision();
  for (const auto& record : version.objects()) {
    scene->objects.push_back({.id = record->id,
                              .surface = sequencer.meshOf(record->id)->surface,
                              .pose = record->pose,
                              .stiffness_N_per_m = record->material.stiffness_N_per_m,
                              .damping_Ns_per_m = record->material.damping_Ns_per_m});
  }
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

bool ServoSceneMaker::planIsOld() const noexcept { return makePlan_ && planRevision_ != revision_; }

std::optional<std::uint64_t> ServoSceneMaker::nextDeparture_ns() const {
  if (leaving_.empty()) return std::nullopt;
  return leaving_.front().until_ns;
}

}  // namespace haptics
