#include "haptic_server/device/movable_workspace.h"

#include <algorithm>
#include <cmath>

#include "common/maths/rotation.h"

namespace haptics {
namespace {

/// Of the hand that pushes the border back: of nobody's who moves faster than 0.6 m/s is it late by the rate of an edit.
constexpr double kBorder_N_per_m = 50, kMaxRate_N_per_s = 30;
/// How far outside of it the workspace is moved at kGlide_m_per_s.
constexpr double kFullSpeedAt_m = 0.02;
/// Of the scene, against which it is not moved any more.
constexpr double kStops_N = 1;

}  // namespace

Result<void> MovableWorkspace::move(const WorkspaceCommand& command) {
  if (!commands_.push(command)) return refused("set_workspace", "comes more often than the servo takes one");
  return {};
}

DeviceReading MovableWorkspace::read(std::uint64_t tick) noexcept {
  DeviceReading reading = device_.read(tick);
  reading.added = wrench_.next();
  for (WorkspaceCommand command; commands_.pop(command);) take(command, reading);
  if (!isMoved_) return reading;
  if (isFinite(reading.position) && isRotation(reading.rotation)) moveClutch(reading);
  glide();
  passBorder(reading);
  const Placed placed = held_ ? *held_ : place(reading);
  reading.position = placed.position;
  reading.rotation = placed.rotation;
  const std::uint32_t pressed = reading.status.buttons;
  reading.status.set(HandAction::kClutch, held_.has_value());
  reading.status.set(HandAction::kGrasp, (pressed & graspButtons_) != 0);
  reading.status.set(HandAction::kMark, (pressed & markButtons_) != 0);
  reading.status.set(HandAction::kNextTool, (pressed & nextToolButtons_) != 0);
  const std::uint32_t bound = clutchButtons_ | graspButtons_ | markButtons_ | nextToolButtons_;
  reading.status.set(HandAction::kNoOther, pressed != 0 && (pressed & ~bound) == 0);
  reading.handle.velocity = scale_ * (rotation_ * reading.handle.velocity);
  reading.handle.appliedForce_N = shrink() * (rotation_ * reading.handle.appliedForce_N);
  return reading;
}

MovableWorkspace::Placed MovableWorkspace::place(const DeviceReading& reading) const noexcept {
  return {offset_ + scale_ * (rotation_ * reading.position),
          glm::normalize(rotation_ * reading.rotation * glm::conjugate(rotation_) * aligned_)};
}

void MovableWorkspace::anchor(const DeviceReading& reading, const Placed& there) noexcept {
  offset_ = there.position - scale_ * (rotation_ * reading.position);
  aligned_ = glm::normalize(glm::conjugate(rotation_ * reading.rotation * glm::conjugate(rotation_)) * there.rotation);
}

void MovableWorkspace::take(const WorkspaceCommand& command, const DeviceReading& reading) noexcept {
  isMoved_ = true;
  clutchButtons_ = command.clutchButtons.value_or(clutchButtons_);
  graspButtons_ = command.graspButtons.value_or(graspButtons_);
  markButtons_ = command.markButtons.value_or(markButtons_);
  nextToolButtons_ = command.nextToolButtons.value_or(nextToolButtons_);
  if (command.scale || command.rotation) {
    const Placed there = held_ ? *held_ : place(reading);
    scale_ = command.scale.value_or(scale_);
    rotation_ = command.rotation.value_or(rotation_);
    if (isFinite(reading.position) && isRotation(reading.rotation)) anchor(reading, there);
  }
  if (command.offset) glidesTo_ = command.offset;
  if (command.bubble) bubble_ = *command.bubble;
}

void MovableWorkspace::moveClutch(const DeviceReading& reading) noexcept {
  const bool pressed = (reading.status.buttons & clutchButtons_) != 0;
  if (pressed == held_.has_value()) return;
  if (pressed) {
    held_ = place(reading);
    glidesTo_.reset();
  } else {
    anchor(reading, *held_);
    held_.reset();
  }
}

void MovableWorkspace::glide() noexcept {
  if (!glidesTo_ || held_) return;
  const Vec3 left = *glidesTo_ - offset_;
  const double length = glm::length(left);
  const double step_m = kGlide_m_per_s * period_s_;
  if (length <= step_m) {
    offset_ = *glidesTo_;
    glidesTo_.reset();
  } else {
    offset_ += left * (step_m / length);
  }
}

void MovableWorkspace::passBorder(DeviceReading& reading) noexcept {
  Vec3 wanted_N(0);
  const Vec3 way = reading.position - bubble_.centre;
  const double distance = glm::length(way), outside_m = distance - bubble_.radius_m;
  if (bubble_.radius_m > 0 && !held_ && outside_m > 0 && std::isfinite(distance)) {
    const Vec3 outward = rotation_ * (way / distance);
    const double back_N = glm::dot(border_N_ - written_N_, outward) / shrink();
    const double part = std::clamp(1 - back_N / kStops_N, 0.0, 1.0);
    const double reach = std::min(1.0, outside_m / kFullSpeedAt_m);
    offset_ += outward * (scale_ * part * reach * reach * reach * kGlide_m_per_s * period_s_);
    glidesTo_.reset();
    wanted_N = outward * (-shrink() * kBorder_N_per_m * outside_m);
  }
  const Vec3 change_N = wanted_N - border_N_;
  const double length_N = glm::length(change_N), most_N = shrink() * kMaxRate_N_per_s * period_s_;
  border_N_ = length_N > most_N ? border_N_ + change_N * (most_N / length_N) : wanted_N;
  if (border_N_ == Vec3(0)) return;
  reading.added = AddedWrench({reading.added.force_N + border_N_, reading.added.torque_Nm});
}

}  // namespace haptics
