#pragma once

#include <cstdint>

#include "common/maths/vec.h"

namespace haptics {

struct ExplorationPlan;

/// What a hand does with the device. World frame.
struct HandTarget {
  Vec3 position{0};  ///< Metres. The intended trajectory: the far end of the hand's spring and damper.
  Vec3 push_N{0};    ///< Besides the spring; moves the device also where the hand has no spring.
};

/// The mind behind a simulated hand. Called by the servo thread; no method waits, allocates, locks or throws.
class HandIntent {
 public:
  virtual ~HandIntent() = default;
  /// The target `dt_s` seconds after the last one, given the force that the motors put on the hand now (newtons, world
  /// frame). A first call with dt_s = 0 asks where the hand begins.
  [[nodiscard]] virtual HandTarget next(double dt_s, Vec3 felt_N) noexcept = 0;
  /// How the hand wants the device to be turned, as next(): asked for only where the device senses it. Length 1.
  [[nodiscard]] virtual Quat nextRotation(double /*dt_s*/) noexcept { return {1, 0, 0, 0}; }
  /// That it presses now: bits of DeviceStatus::buttons.
  [[nodiscard]] virtual std::uint32_t buttons() const noexcept { return 0; }
  /// How far it wants the gripper to be open, asked for as nextRotation(), of a device that has one: `now_rad`, or somewhere else.
  [[nodiscard]] virtual double nextGripper_rad(double /*dt_s*/, double now_rad) noexcept { return now_rad; }
  /// As Device::follow().
  virtual void follow(const ExplorationPlan* /*plan*/) noexcept {}
};

}  // namespace haptics
