#include "haptic_server/engine/step/kinematic_motion.h"

#include <algorithm>
#include <cmath>

#include "common/maths/rotation.h"

namespace haptics {
namespace {

/// No point of the surface goes farther.
[[nodiscard]] double longestWay_m(const CollisionMesh& surface, const Pose& from, const Pose& to) noexcept {
  const double angle_rad = glm::length(rotationVector(to.rotation * glm::conjugate(from.rotation)));
  return glm::distance(toWorld(from, surface.centre()), toWorld(to, surface.centre())) + angle_rad * surface.radius_m();
}

}  // namespace

bool moveDrivenObject(const ServoScene& scene, HapticState& state, double period_s, std::size_t object) noexcept {
  const KinematicPose& sample = scene.kinematic[object];
  KinematicMotion& motion = state.driven[object];
  if (sample.number == 0) {
    motion = {};
    return false;
  }
  const Body& body = state.bodies[object];
  const double longest = kLongestPause_s / period_s;  // ticks
  if (motion.number != sample.number) {
    const bool goesOn = motion.number != 0 && static_cast<double>(motion.since) < longest;
    const double first = longestWay_m(*body.surface, body.current, sample.pose) / (kFirstSpeed_m_per_s * period_s);
    motion.left = goesOn ? motion.since : static_cast<std::uint64_t>(std::round(std::clamp(first, 1.0, longest)));
    motion.since = 0;
    motion.number = sample.number;
    state.objects[object].beingMoved = false;
  }
  if (motion.left > 0) {
    const Pose previous = lastTestedPose(state, body);
    state.place(object, previous,
                motion.left == 1 ? sample.pose
                                 : interpolate(body.current, sample.pose, 1.0 / static_cast<double>(motion.left)));
    --motion.left;
  } else if (body.moving) {
    state.place(object, lastTestedPose(state, body), body.current);
  }
  const bool goesOn = static_cast<double>(motion.since) < longest;
  if (goesOn) ++motion.since;
  return goesOn || motion.left > 0 || body.moving;
}

void beginDriving(HapticState& state) noexcept {
  if (state.driven.count == 0) std::fill_n(state.driven.items.begin(), state.objects.count, KinematicMotion{});
  state.driven.count = state.objects.count;
  state.features.beingMoved = true;
}

void moveDrivenObjects(const ServoScene& scene, HapticState& state, double period_s) noexcept {
  for (std::size_t i = 0; i < state.driven.count; ++i) static_cast<void>(moveDrivenObject(scene, state, period_s, i));
}

}  // namespace haptics
