#include "haptic_server/device/presets.h"

#include <array>
#include <numbers>
#include <string>

namespace haptics {
namespace {

// Force limit, stiffness and damping: as published by common haptic toolkits for these devices. Mass, Coulomb friction
// and resolution: from the makers' data sheets, approximate (data sheets give back-drive friction and nominal
// resolution at the middle of the workspace). Viscous friction is published for none of them (Diolaiti et al. 2006
// measured 0.005 N s/m and 0.038 N on a Phantom 1.0 alone), so it is assumed: 0.05 for serial arms, 0.5 for grounded
// delta devices. Judge stability also at a third and at three times what is assumed here.
// Rotation: torque limit and torsion as published by the same toolkits, resolution from the data sheets. Range of the gripper:
// as published by CHAI3D, the same for an omega.7, and its force, 8 N, here on a lever of kUsualGyration_m. How stiff it may be
// is published for none: assumed is the torsion.
// Inertia and friction about the grip are published for none: assumed are those of the tip on a lever of kUsualGyration_m.
constexpr double kAssumedSerialViscous = 0.05;  // N s/m
constexpr double kAssumedDeltaViscous = 0.5;    // N s/m
constexpr double kAssumedCoulomb = 0.05;        // N, where the maker gives none
constexpr double kAssumedFalconMass = 0.25;     // kg, estimates of the moving parts differ
constexpr double kAssumedOmegaMass = 0.2;       // kg
constexpr double kAssumedWristMass = 0.3;       // kg, of those that turn the hand

constexpr DeviceRotation turning(double maxTorque_Nm, double maxTorsion_Nm_per_rad, double resolution_rad,
                                 double mass_kg, double viscous, double coulomb) {
  constexpr double r = kUsualGyration_m;
  return {true, maxTorque_Nm, maxTorsion_Nm_per_rad, resolution_rad, mass_kg * r * r, viscous * r * r, coulomb * r};
}
constexpr double degrees(double angle) { return angle * std::numbers::pi / 180; }

constexpr std::array kDevices{
    // name, title, F_max N, K N/m, B N s/m, m kg, b N s/m, f_c N, resolution m; of rotation T_max Nm, K_r Nm/rad, resolution;
    // of the gripper rad, Nm, Nm/rad
    DevicePreset{"omni", "Phantom Omni", 3.3, 700, 5, 0.045, kAssumedSerialViscous, 0.26, 55e-6},
    // The Omni under its later name: the same mechanics, published with lower gains.
    DevicePreset{"touch", "3D Systems Touch", 3.3, 400, 4, 0.045, kAssumedSerialViscous, 0.26, 55e-6},
    DevicePreset{"premium-1.5", "Phantom Premium 1.5", 8.5, 800, 5, 0.075, kAssumedSerialViscous, 0.04, 30e-6},
    DevicePreset{"desktop", "Phantom Desktop", 7.9, 1000, 5, 0.045, kAssumedSerialViscous, 0.06, 23e-6},
    DevicePreset{"falcon", "Novint Falcon", 8.0, 3000, 20, kAssumedFalconMass, kAssumedDeltaViscous, kAssumedCoulomb,
                 60e-6},
    DevicePreset{"omega.3", "Force Dimension omega.3", 12, 5000, 30, kAssumedOmegaMass, kAssumedDeltaViscous,
                 kAssumedCoulomb, 10e-6},
    DevicePreset{"omega.6", "Force Dimension omega.6", 12, 5000, 30, kAssumedOmegaMass, kAssumedDeltaViscous,
                 kAssumedCoulomb, 10e-6,
                 turning(0, 0, degrees(0.09), kAssumedOmegaMass, kAssumedDeltaViscous, kAssumedCoulomb)},
    DevicePreset{"sigma.7",
                 "Force Dimension sigma.7",
                 12,
                 4000,
                 30,
                 kAssumedWristMass,
                 kAssumedDeltaViscous,
                 kAssumedCoulomb,
                 1.5e-6,
                 turning(0.2, 1, degrees(0.013), kAssumedWristMass, kAssumedDeltaViscous, kAssumedCoulomb),
                 {degrees(30), 0.4, 1}},
};

// Mass, stiffness and damping of a hand that holds a stylus: all assumed, from a loose to a tight grip; "none" lets go.
constexpr std::array kHands{
    HandPreset{"none", 0, 0, 0},
    HandPreset{"light", 0.05, 100, 0.5},
    HandPreset{"nominal", 0.15, 300, 3},
    HandPreset{"firm", 0.3, 800, 8},
};

template <class Table>
auto findIn(const Table& table, std::string_view name, const std::string& kind) -> Result<typename Table::value_type> {
  std::string known;
  for (const auto& preset : table) {
    if (preset.name == name) return preset;
    known += (known.empty() ? "" : ", ") + std::string(preset.name);
  }
  return refused("", "no " + kind + " is called \"" + std::string(name) + "\"; there are " + known);
}

}  // namespace

std::span<const DevicePreset> devicePresets() noexcept { return kDevices; }
std::span<const HandPreset> handPresets() noexcept { return kHands; }

Result<DevicePreset> findDevicePreset(std::string_view name) { return findIn(kDevices, name, "device preset"); }
Result<HandPreset> findHandPreset(std::string_view name) { return findIn(kHands, name, "hand preset"); }

}  // namespace haptics
