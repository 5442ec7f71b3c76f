#pragma once

#include <cstdint>
#include <string>

#include "common/maths/vec.h"
#include "common/telemetry/device_reading.h"
#include "haptic_server/device/device_rotation.h"

namespace haptics {

/// Fixed for the life of a device.
struct DeviceInfo {
  std::string name;
  double maxForce_N = 0;  ///< The magnitude limit uses it.
  double maxStiffness_N_per_m = 0;
  double maxDamping_Ns_per_m = 0;
  double resolution_m = 0;  ///< Position quantum.
  /// Dynamics of the device alone, as at a point; a mass of 0 when they are not known.
  double apparentMass_kg = 0, viscousFriction_Ns_per_m = 0, coulombFriction_N = 0;
  double delay_s = 0;  ///< Measured: from reading a position to the motors' force, beyond the hold.
  DeviceRotation rotation{};
  DeviceGripper gripper{};
};

/// The radius (m) on which the device turns as its mass moves, sqrt(I / m); kUsualGyration_m where that is not known.
[[nodiscard]] double gyration_m(const DeviceInfo& device) noexcept;

/// How the device turns, as the translation of a mass on the radius r = gyration_m(): x = r angle, F = T / r, m = I / r^2,
/// K = K_r / r^2. Exact where the inertia is the same about all axes, w x I w = 0. So what is known of translations, their
/// observer and their limits of stiffness, is known of rotations.
[[nodiscard]] DeviceInfo rotationAsTranslation(const DeviceInfo& device);

struct ExplorationPlan;

/// A force-feedback device as the servo thread sees it: a pose to read, a force and a torque to write, each tick.
/// read, write and stop never wait, allocate, lock or throw.
class Device {
 public:
  virtual ~Device() = default;
  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
  /// Is there a position that read() has not given yet? One that comes in time for a tick, but late, is worth waiting for.
  [[nodiscard]] virtual bool hasNewSample() noexcept { return true; }
  /// The newest position. `tick` counts servo periods and may skip: missed ticks.
  [[nodiscard]] virtual DeviceReading read(std::uint64_t tick) noexcept = 0;
  /// Newton metres on the hand, world frame, from the next write() on. Only where a tool is held, or
  /// a client adds one: zero until then.
  virtual void writeTorque(Vec3 /*torque_Nm*/) noexcept {}
  /// Newton metres on the gripper, that open it above 0; likewise, only where a tool with jaws is held.
  virtual void writeGrip(double /*moment_Nm*/) noexcept {}
  /// Newtons on the hand, world frame, held until the next write.
  virtual void write(Vec3 force_N) noexcept = 0;
  /// What a simulated hand is to explore from now on, null for nothing; valid until the next call. A real device has a
  /// hand of its own.
  virtual void follow(const ExplorationPlan* /*plan*/) noexcept {}
  /// Zero force from now on.
  virtual void stop() noexcept = 0;
};

}  // namespace haptics
