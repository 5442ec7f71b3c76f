#pragma once

#include <span>
#include <string_view>

#include "common/error/error.h"
#include "haptic_server/device/device_rotation.h"

namespace haptics {

/// A force-feedback device as a point mass in Cartesian space, equal in all directions.
struct DevicePreset {
  std::string_view name;   ///< As on the command line.
  std::string_view title;  ///< For people.
  double maxForce_N;
  double maxStiffness_N_per_m;
  double maxDamping_Ns_per_m;
  double apparentMass_kg;
  double viscousFriction_Ns_per_m;
  double coulombFriction_N;
  double resolution_m;  ///< Position quantum.
  DeviceRotation rotation{};
  DeviceGripper gripper{};
};

/// A hand holding the device: its mass joined rigidly to the device's, a spring and a damper to where it wants to be. A
/// device that turns is held by these on a lever of kUsualGyration_m, and so is a gripper, which has no mass.
struct HandPreset {
  std::string_view name;
  double mass_kg;
  double stiffness_N_per_m;
  double damping_Ns_per_m;
};

inline constexpr std::string_view kDefaultDevicePreset = "omni";
inline constexpr std::string_view kDefaultHandPreset = "nominal";

[[nodiscard]] std::span<const DevicePreset> devicePresets() noexcept;
[[nodiscard]] std::span<const HandPreset> handPresets() noexcept;

/// Refused: a name that is not in the table; the reason lists those that are.
[[nodiscard]] Result<DevicePreset> findDevicePreset(std::string_view name);
[[nodiscard]] Result<HandPreset> findHandPreset(std::string_view name);

}  // namespace haptics
