#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/maths/vec.h"

namespace haptics {

/// Hands of a server that clients may lead.
inline constexpr std::size_t kMaxLedHands = 2;

/// A simulated hand presses with at most its device's largest force divided by this, which is left for what cannot be
/// foreseen: friction, texture, damping.
inline constexpr double kForceReserve = 1.2;

/// Where a client wants the simulated hand now. World frame.
struct HandCommand {
  bool leads = false;  ///< Else nobody leads, and the rest means nothing.
  Vec3 position{0};    ///< Metres.
  Vec3 normal{0};  ///< Length 1, towards the hand; of the surface that it presses. Means nothing where press_N is 0.
  double press_N = 0;                   ///< Against the normal; not negative.
  Quat rotation{1, 0, 0, 0};            ///< Length 1; of a device that turns, from how it is turned at rest.
  std::uint32_t buttons = 0;            ///< That it presses: bits of DeviceStatus::buttons.
  std::optional<double> gripper_rad{};  ///< Opening of the device's gripper, not negative; absent: as it is.
};

/// A sphere in the device's own coordinates (m), beyond which the hand moves its workspace by velocity; of radius 0: none.
struct Bubble {
  Vec3 centre{0};
  double radius_m = 0;
};

/// Where a client wants the workspace of a device, and its buttons bound, from now on; what is absent stays as it is.
struct WorkspaceCommand {
  std::optional<Vec3> offset{};    ///< Metres; the workspace glides there.
  std::optional<double> scale{};   ///< 0.1 to 10; about where the hand is.
  std::optional<Quat> rotation{};  ///< Length 1; likewise.
  /// Bits of DeviceStatus::buttons, each of which does what its HandAction says.
  std::optional<std::uint32_t> clutchButtons{}, graspButtons{}, markButtons{}, nextToolButtons{};
  std::optional<Bubble> bubble{};
};

}  // namespace haptics
