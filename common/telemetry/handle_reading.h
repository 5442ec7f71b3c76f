#pragma once

#include <cstdint>

#include "common/maths/vec.h"

namespace haptics {

/// What some devices measure besides the pose of their handle; zeros where it is not measured. World frame.
struct HandleReading {
  /// Bits of `measured`.
  static constexpr std::uint64_t kVelocity = 1, kAppliedForce = 2, kGripper = 4, kAll = 7;

  Vec3 velocity{0};  ///< m/s.
  Vec3 appliedForce_N{
      0};  ///< On the hand: what the device says that it applies, which may differ from what was written.
  double gripper_rad = 0;  ///< Opening of the gripper.
  std::uint64_t measured = 0;

  [[nodiscard]] bool has(std::uint64_t bit) const noexcept { return (measured & bit) != 0; }
  bool operator==(const HandleReading&) const = default;
};

}  // namespace haptics
