#pragma once

#include "common/maths/vec.h"

namespace haptics {

/// Force and torque on the hand, world frame.
struct Wrench {
  Vec3 force_N{0};
  Vec3 torque_Nm{0};

  bool operator==(const Wrench&) const = default;
};

/// What a client adds in a tick to the wrench of the scene.
struct AddedWrench : Wrench {
  bool acts = false;  ///< Else both are zero.

  AddedWrench() noexcept = default;
  explicit AddedWrench(const Wrench& wrench) noexcept : Wrench(wrench), acts(!(wrench == Wrench{})) {}

  bool operator==(const AddedWrench&) const = default;
};

}  // namespace haptics
