#include "graphics_client/application/hand_steering.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptics {
namespace {

/// m/s. Of the hand that comes from far above; the last bit down is the server's, which lands slowly.
constexpr double kApproachSpeed_m_per_s = 0.3;
/// It comes along the line of sight, where nothing is between, from at most so far; and not before it is beside the line by
/// less than this.
constexpr double kLongestApproach_m = 0.08, kBeside_m = 0.02;
/// Seconds. What normals from pixel to pixel are smoothed over.
constexpr double kNormalTime_s = 0.05;

}  // namespace

void HandSteering::setPress_N(double press_N) { press_N_ = std::clamp(press_N, kMinPress_N, kMaxPress_N); }

void HandSteering::changePress(double clicks) {
  constexpr double kPerClick = 1.2;
  setPress_N(press_N_ * std::pow(kPerClick, clicks));
}

void HandSteering::openGripper(double clicks, double now_rad) {
  constexpr double kPerClick_rad = std::numbers::pi / 90;
  const double wanted = gripper_rad_.value_or(now_rad);
  const double from = clicks < 0 ? std::min(wanted, now_rad) : std::max(wanted, now_rad);
  gripper_rad_ = std::clamp(from + kPerClick_rad * clicks, 0.0, std::numbers::pi);
}

void HandSteering::begin(Vec3 hip) {
  hand_ = hip;
  rotation_ = {1, 0, 0, 0};
  gripper_rad_.reset();
  wasPressed_ = touched_ = false;
}

HandCommand HandSteering::next(const Pointer& pointer, Vec3 hip, double dt_s) {
  HandCommand command = mapping_ == Mapping::kSurface ? onSurface(pointer, hip, dt_s) : inSpace(pointer);
  command.rotation = rotation_;
  command.gripper_rad = gripper_rad_;
  wasPressed_ = pointer.pressed;
  hand_ = command.position;
  return command;
}

HandCommand HandSteering::onSurface(const Pointer& pointer, Vec3 hip, double dt_s) {
  const bool presses = pointer.pressed && pointer.surface;
  if (pointer.surface && (presses || !pointer.pressed)) {
    const double share = touched_ ? 1 - std::exp(-dt_s / kNormalTime_s) : 1;
    const Vec3 turned = glm::mix(normal_, pointer.surface->normal, share);
    if (glm::length(turned) > 0) normal_ = glm::normalize(turned);
    place_ = pointer.surface->position;
    touched_ = true;
  }
  if (!touched_) return {.leads = true, .position = hand_};
  if (presses && !wasPressed_) {
    clearance_m_ = std::clamp(glm::distance(hip, place_), clearance_m_, kLongestApproach_m);
  }
  const bool isFar = clearance_m_ > kHover_m;
  const Vec3 along = isFar ? glm::normalize(pointer.eye - place_) : normal_;
  if (presses) {
    if (!isFar) return {.leads = true, .position = place_, .normal = normal_, .press_N = press_N_};
    const double beside = glm::distance(hip, place_ + along * clearance_m_);
    if (beside < kBeside_m) clearance_m_ = std::max(kHover_m, clearance_m_ - kApproachSpeed_m_per_s * dt_s);
  }
  return {.leads = true, .position = place_ + along * clearance_m_};
}

HandCommand HandSteering::inSpace(const Pointer& pointer) {
  if (pointer.pressed && !wasPressed_) grabbedAt_ = hand_ - pointer.onPicture;
  return {.leads = true, .position = pointer.pressed ? pointer.onPicture + grabbedAt_ : hand_};
}

}  // namespace haptics
