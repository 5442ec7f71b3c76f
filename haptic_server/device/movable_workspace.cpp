#include "haptic_server/device/movable_workspace.h"

#include "common/maths/rotation.h"

namespace haptics {

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
  const Placed placed = held_ ? *held_ : place(reading);
  reading.position = placed.position;
  reading.rotation = placed.rotation;
  reading.status.clutched = held_.has_value();
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
  if (command.scale || command.rotation) {
    const Placed there = held_ ? *held_ : place(reading);
    scale_ = command.scale.value_or(scale_);
    rotation_ = command.rotation.value_or(rotation_);
    if (isFinite(reading.position) && isRotation(reading.rotation)) anchor(reading, there);
  }
  if (command.offset) glidesTo_ = command.offset;
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
  if (length <= glide_m_) {
    offset_ = *glidesTo_;
    glidesTo_.reset();
  } else {
    offset_ += left * (glide_m_ / length);
  }
}

}  // namespace haptics
