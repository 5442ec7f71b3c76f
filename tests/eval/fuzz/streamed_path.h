#pragma once

#include "common/maths/rotation.h"
#include "haptic_server/world/stepped_scene.h"

namespace haptics::eval {

[[nodiscard]] inline World::Pose worldPose(const Pose& pose) {
  return {vectorOf(pose.position), {pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z}};
}

/// Where a body that is driven is in each tick, by what world.h says of moveKinematic(). It turns as the step turns it; turned
/// evenly it would be up to 0.3 um beside that.
class StreamedPath {
 public:
  explicit StreamedPath(const Pose& at) : to_(at), at_(at) {}

  void sample(const Pose& to, int ticks) {
    to_ = to;
    left_ = ticks;
  }
  void tick() {
    if (left_ == 0) return;
    at_ = left_ == 1 ? to_ : interpolate(at_, to_, 1.0 / left_);
    --left_;
  }
  [[nodiscard]] const Pose& at() const noexcept { return at_; }

 private:
  Pose to_, at_;
  int left_ = 0;
};

}  // namespace haptics::eval
