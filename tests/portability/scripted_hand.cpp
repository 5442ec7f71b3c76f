#include "tests/portability/scripted_hand.h"

#include <numbers>

#include "common/maths/elementary.h"
#include "common/maths/rotation.h"
#include "haptic_server/engine/step/moving_bodies.h"

namespace haptics::portability {
namespace {

constexpr double kClear_m = 0.015;
constexpr double kDepth_m = 0.0015;
constexpr double kSway_m = 0.0003;
constexpr double kSlide_m = 0.02;
constexpr double kTilt_rad = 0.2;

}  // namespace

ScriptedHand::ScriptedHand(const ServoScene& scene) {
  for (const ServoObject& object : scene.objects) {
    if (!object.tool) objects_.push_back(&object);
  }
}

void ScriptedHand::chooseStroke(std::uint64_t stroke, const HapticState& state) {
  const ServoObject& object = *objects_[stroke % objects_.size()];
  Pose pose = object.pose;
  MotionState motion;
  (void)updateMotionState(state, 0, motion);
  for (const BodyState& body : motion.bodies()) {
    if (body.object == object.id) pose = body.pose;
  }
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;  // spreads consecutive numbers evenly
  const auto number = static_cast<std::uint32_t>((stroke * kGolden >> 32) % object.surface->triangleCount());
  const TriangleRecord& triangle = object.surface->triangle(number);
  const Vec3 a = triangle.corner(0), b = triangle.corner(1), c = triangle.corner(2);
  from_ = last_;
  place_ = toWorld(pose, (a + b + c) / 3.0);
  normal_ = pose.rotation * object.surface->faceNormal(number);
  const Vec3 side = pose.rotation * (b - a);
  along_ = squaredLength(side) > 0 ? side / glm::length(side) : Vec3(1, 0, 0);
}

DeviceReading ScriptedHand::at(std::uint64_t tick, const HapticState& state) {
  const std::uint64_t within = tick % kStrokeTicks;
  if (within == 0) chooseStroke(tick / kStrokeTicks, state);
  const auto part = [within](std::uint64_t begin, std::uint64_t end) {
    return static_cast<double>(within - begin) / static_cast<double>(end - begin);
  };
  const Vec3 above = place_ + kClear_m * normal_, pressed = place_ - kDepth_m * normal_;
  const auto swing = [](double turns) { return elementary::sin(2 * std::numbers::pi * turns); };
  if (within < 120) {
    last_ = glm::mix(from_, above, part(0, 120));
  } else if (within < 200) {
    last_ = glm::mix(above, pressed, part(120, 200));
  } else if (within < 280) {
    last_ = pressed + kSway_m * swing(2 * part(200, 280)) * along_;
  } else if (within < 440) {
    const double way = part(280, 440);
    last_ = pressed + kSlide_m * way * along_ + kDepth_m / 2 * swing(4 * way) * normal_;
  } else {
    last_ = pressed + kSlide_m * along_ + part(440, 500) * (kClear_m + kDepth_m) * normal_;
  }
  DeviceReading reading{last_, DeviceState::kReady};
  const double turns = static_cast<double>(tick) / 1700;
  reading.rotation = rotationBy(kTilt_rad * Vec3(swing(turns), swing(1.3 * turns), swing(0.7 * turns)));
  return reading;
}

}  // namespace haptics::portability
