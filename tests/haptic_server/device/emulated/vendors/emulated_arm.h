#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace haptics {

/// A vendor's device as its library shows it, in the vendor's units and frame. It lies in memory that the library shares with
/// the process of the arm (arm_main.cpp) where EMULATED_ARM names a file, and in the library's own elsewhere; all zero to
/// begin with.
struct EmulatedArm {
  template <class Value>
  using Shared = std::atomic<Value>;

  // The hand's side.
  std::array<Shared<double>, 3> position, velocity;
  std::array<Shared<double>, 9> rotation;  ///< Rows.
  Shared<double> gripper_rad;
  Shared<std::uint32_t> buttons;

  // The program's side: what it called, newest.
  std::array<Shared<double>, 3> force, torque;
  Shared<double> gripperForce;
  Shared<std::uint64_t> written_ns;  ///< CLOCK_MONOTONIC.
  Shared<std::uint32_t> writes, opens, movesByItself;

  // Firmware.
  Shared<std::uint32_t> type, hasWrist, hasActiveWrist, hasGripper;
  Shared<std::uint32_t> initialised, forceOn, forceOffCause;
  Shared<std::uint64_t> watchdog_ns;  ///< 0: off.

  // Faults, which last while they are not 0.
  Shared<std::uint32_t> unplugged, inUse, communication, timeGuard, notFinite, jumped, saturated, lost;
  Shared<std::uint32_t> blocks_us;  ///< Each call for so long.
};
static_assert(std::atomic<double>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);

}  // namespace haptics
