#include "haptic_server/device/leadable_hand.h"

#include <algorithm>

#include "common/maths/elementary.h"
#include "common/maths/rotation.h"
#include "haptic_server/device/press_control.h"

namespace haptics {
namespace {

/// 1/s. Of the critically damped filter between commands and hand: it lags by 2 / kRate_per_s = 13 ms.
constexpr double kRate_per_s = 150;
/// Seconds. What the time between commands is taken for at least, and before the second one has come.
constexpr double kShortestInterval_s = 0.004, kUsualInterval_s = 1.0 / 60;
constexpr double kNewIntervalShare = 0.2;
constexpr double kLiftSpeed_m_per_s = 0.06;
constexpr double kTurnRate_per_s = 15;  // of the way that is left
/// 1/s. Above the commanded place it comes down faster the higher it is, beyond this height.
constexpr double kLandRate_per_s = 8, kSlowHeight_m = 0.005;
constexpr double kLargestHeight_m = 0.1;
/// Newtons below which a retreat is at its end, and the metres after which it is given up.
constexpr double kNoPress_N = 0.02, kLongestRetreat_m = 0.04;
/// Metres: an offset that no encoder resolves.
constexpr double kNoOffset_m = 1e-8;

Vec3 shortened(Vec3 vector, double longest) noexcept {
  const double length = glm::length(vector);
  return length > longest ? vector * (longest / length) : vector;
}

/// x'' = rate^2 (to - x) - 2 rate x' within the limits of acceleration and speed, one step of it, semi-implicit.
void filter(Vec3 to, double dt_s, Vec3& x, Vec3& velocity) noexcept {
  const Vec3 wanted = kRate_per_s * (kRate_per_s * (to - x) - 2.0 * velocity);
  velocity += dt_s * shortened(wanted, LeadableHand::kMaxAcceleration_m_per_s2);
  velocity = shortened(velocity, LeadableHand::kMaxSpeed_m_per_s);
  x += dt_s * velocity;
}

}  // namespace

LeadableHand::LeadableHand(const HandPreset& hand, double maxForce_N, double startsAt) noexcept
    : exploring_(hand, maxForce_N, startsAt),
      maxPress_N_(maxForce_N / kForceReserve),
      depthPerForce_(hand.stiffness_N_per_m > 0 ? kForceCorrection_per_s / hand.stiffness_N_per_m : 0),
      interval_s_(kUsualInterval_s) {}

HandTarget LeadableHand::next(double dt_s, Vec3 felt_N) noexcept {
  if (dt_s == 0) return explore(dt_s, felt_N);
  age_s_ += dt_s;
  sinceRetreat_s_ += dt_s;
  if (const HandCommand* const newest = commands_.takeNew()) {
    const double felt = glm::length(felt_N);
    if (!newest->leads) {
      release();
    } else if (phase_ == Phase::kExploring && felt > kNoPress_N && sinceRetreat_s_ > kReleased_s) {
      command_.normal = felt_N / felt;
      pressed_N_ = felt;
      beginRetreat();
    } else if (phase_ != Phase::kRetreating) {
      take(*newest);
    }
  }
  if (phase_ == Phase::kLed && age_s_ > kReleased_s) release();
  if (phase_ == Phase::kExploring) return explore(dt_s, felt_N);
  pressed_N_ += (glm::dot(felt_N, command_.normal) - pressed_N_) * (dt_s / (kFeltSmoothing_s + dt_s));
  if (phase_ == Phase::kRetreating) {
    retreat(dt_s);
  } else {
    if (age_s_ <= kHeld_s) press(dt_s);
    filter(commanded(), dt_s, position_, velocity_);
  }
  return {position_, Vec3(0)};
}

Quat LeadableHand::nextRotation(double dt_s) noexcept {
  const Quat explored = exploring_.nextRotation(phase_ == Phase::kExploring ? dt_s : 0);
  const Quat wanted = phase_ == Phase::kExploring ? explored : command_.rotation;
  const Vec3 way = rotationVector(wanted * glm::conjugate(rotation_));
  const double part = 1 - elementary::exp(-kTurnRate_per_s * dt_s);
  rotation_ = glm::normalize(rotationBy(shortened(part * way, kMaxTurn_rad_per_s * dt_s)) * rotation_);
  return rotation_;
}

double LeadableHand::nextGripper_rad(double dt_s, double now_rad) noexcept {
  if (phase_ != Phase::kLed || !command_.gripper_rad) return now_rad;
  const double most = kMaxTurn_rad_per_s * dt_s;
  return now_rad + std::clamp(*command_.gripper_rad - now_rad, -most, most);
}

HandTarget LeadableHand::explore(double dt_s, Vec3 felt_N) noexcept {
  HandTarget target = exploring_.next(dt_s, felt_N);
  if (offset_ != Vec3(0) || offsetVelocity_ != Vec3(0)) {
    filter(Vec3(0), dt_s, offset_, offsetVelocity_);
    if (glm::length(offset_) + glm::length(offsetVelocity_) / kRate_per_s < kNoOffset_m) {
      offset_ = offsetVelocity_ = Vec3(0);
    }
    target.position += offset_;
  }
  if (dt_s > 0) velocity_ = (target.position - position_) / dt_s;
  position_ = target.position;
  return target;
}

void LeadableHand::take(const HandCommand& command) noexcept {
  if (phase_ == Phase::kLed) {
    interval_s_ += kNewIntervalShare * (std::clamp(age_s_, kShortestInterval_s, kHeld_s) - interval_s_);
    from_ = glm::mix(from_, command_.position, std::min(age_s_ / interval_s_, 1.0));
  } else {
    from_ = position_;
    interval_s_ = kUsualInterval_s;
    depth_m_ = pressed_N_ = command_.press_N = 0;
    phase_ = Phase::kLed;
  }
  // A command that presses nowhere goes on away from the surface that was pressed.
  const bool presses = command.press_N > 0;
  const Vec3 normal = presses ? command.normal : command_.normal;
  if (presses != (command_.press_N > 0)) {  // it lands and lifts slowly, however late the commands come
    const Vec3 now = from_ - command_.normal * depth_m_;
    depth_m_ = std::clamp(glm::dot(command.position - now, normal), -kLargestHeight_m, kLargestHeight_m);
    from_ = now + normal * depth_m_;
  }
  command_ = command;
  command_.normal = normal;
  command_.press_N = std::min(command.press_N, maxPress_N_);
  age_s_ = 0;
}

void LeadableHand::release() noexcept {
  if (phase_ == Phase::kLed) beginRetreat();
}

void LeadableHand::beginRetreat() noexcept {
  phase_ = Phase::kRetreating;
  from_ = position_;
  retreat_m_ = 0;
}

/// Then the exploring hand goes on from there: it lifts, and what this one moved is taken out within some 50 ms.
void LeadableHand::retreat(double dt_s) noexcept {
  retreat_m_ += kLiftSpeed_m_per_s * dt_s;
  filter(from_ + command_.normal * retreat_m_, dt_s, position_, velocity_);
  if (pressed_N_ > kNoPress_N && retreat_m_ < kLongestRetreat_m) return;
  sinceRetreat_s_ = 0;
  phase_ = Phase::kExploring;
  exploring_.resumeAt(position_);
  offset_ = Vec3(0);
  offsetVelocity_ = velocity_;
}

/// As the exploring hand presses: the depth follows the error of the force.
void LeadableHand::press(double dt_s) noexcept {
  if (command_.press_N > 0) {
    const double speed = depthPerForce_ * (command_.press_N - pressed_N_);
    const double landing = std::max(kPressSpeed_m_per_s, kLandRate_per_s * (-depth_m_ - kSlowHeight_m));
    depth_m_ += depth_m_ < 0 && pressed_N_ < kNoPress_N
                    ? landing * dt_s
                    : std::clamp(speed, -kLiftSpeed_m_per_s, kPressSpeed_m_per_s) * dt_s;
    depth_m_ = std::clamp(depth_m_, -kLargestHeight_m, kMaxPressDepth_m);
  } else {
    const double most = kLiftSpeed_m_per_s * dt_s;
    depth_m_ -= std::clamp(depth_m_, -most, most);
  }
}

Vec3 LeadableHand::commanded() const noexcept {
  return glm::mix(from_, command_.position, std::min(age_s_ / interval_s_, 1.0)) - command_.normal * depth_m_;
}

}  // namespace haptics
