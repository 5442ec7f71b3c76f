#include "tests/eval/walk/tool_walker.h"

#include <cmath>

#include "common/maths/rotation.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {
namespace {

/// The surface of a tool is some 10 mm about its middle, and its farthest point 27 mm from it.
constexpr WalkRange kRange{.highest_m = 0.012, .deepest_m = 0.005, .fastest_m_per_s = 1, .startsApart_m = 0.03};
constexpr double kSlowest_rad_per_s = 0.1, kFastest_rad_per_s = 10;
/// From the tool to where the hand means to turn it, and at which it gives up.
constexpr double kFarthest_rad = 0.7, kGivesUp_rad = 1;

[[nodiscard]] Vec3 turnFrom(const Quat& from, const Quat& to) { return rotationVector(to * glm::conjugate(from)); }

}  // namespace

ToolWalker::ToolWalker(const TriangleSoup& soup, Random random)
    : position_(soup, random, kRange), random_(random), rotation_(random_.rotation()), target_(rotation_) {}

Pose ToolWalker::next(const Pose& tool) {
  constexpr double kInertia = 0.8;  // of the spin, a tick
  const Vec3 way = turnFrom(rotation_, target_);
  const double left = glm::length(way);
  if (left < 2 * speed_ * kPeriod_s || glm::length(turnFrom(tool.rotation, rotation_)) > kGivesUp_rad) choose(tool);
  const Vec3 wanted = left > 0 ? way * (speed_ / left) : Vec3(0);
  spin_ = spin_ * kInertia + wanted * (1 - kInertia);
  rotation_ = glm::normalize(rotationBy(spin_ * kPeriod_s) * rotation_);
  static_cast<void>(position_.next());
  return device();
}

void ToolWalker::choose(const Pose& tool) {
  target_ = glm::normalize(rotationBy(random_.direction() * random_.between(0, kFarthest_rad)) * tool.rotation);
  speed_ = kSlowest_rad_per_s * std::pow(kFastest_rad_per_s / kSlowest_rad_per_s, random_.between(0, 1));
}

}  // namespace haptics::eval
