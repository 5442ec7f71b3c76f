#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptic_server/device/device.h"
#include "haptic_server/device/hand_intent.h"
#include "haptic_server/device/plant.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/device/simulated_rotation.h"

namespace haptics {

struct SimulationSettings {
  DevicePreset device;
  HandPreset hand;
  double period_s = 1e-3;  ///< Of the servo; positive.
  double delay_s = 0;      ///< From a write to the motors, beyond the hold; not negative, rounded to a substep.
};

/// The device that another one's driver describes, to be simulated.
[[nodiscard]] DevicePreset presetOf(const DeviceInfo& device) noexcept;

/// A device and a hand that exist only here, advanced by the ticks themselves: it has no clock, and the same ticks and
/// forces give the same positions, bit for bit. It quantises positions and saturates forces as its preset says, rotations and
/// torques likewise where it has them. A gripper is as far open as the hand wants it within its range, which gives way to a
/// moment; closed at first.
class SimulatedDevice final : public Device {
 public:
  /// Substeps per tick of the integration; also the resolution of the delay. The plant is smooth within a tick except
  /// where friction sticks, and the integrator is of second order, so 20 leaves errors far below a position quantum.
  static constexpr int kSubsteps = 20;
  /// Skipped ticks are integrated too, under the held force, but no more than this many at once: after a longer gap
  /// (a stopped process) simulated time is lost rather than the deadline of the tick that comes.
  static constexpr std::uint64_t kMaxTicksAtOnce = 100;

  /// `intent` outlives the device and is called from read().
  SimulatedDevice(const SimulationSettings& settings, HandIntent& intent);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  /// The first call places the device where the hand begins; a later one integrates up to `tick`.
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override;
  /// What read(tick) of each would integrate, a tick at most, with the same results, in a third of the time: the processor
  /// overlaps their substeps, which wait for nothing but their own.
  static void advanceTogether(std::span<SimulatedDevice* const> devices, std::uint64_t tick) noexcept;
  /// A force beyond the device's limit is shortened to it; one that is not finite is zero.
  void write(Vec3 force_N) noexcept override;
  void writeTorque(Vec3 torque_Nm) noexcept override;
  void writeGrip(double moment_Nm) noexcept override;
  void follow(const ExplorationPlan* plan) noexcept override { intent_.follow(plan); }
  /// Later writes are ignored.
  void stop() noexcept override;

  /// Beneath the encoders, for evaluation.
  [[nodiscard]] const Plant& plant() const noexcept { return plant_; }
  [[nodiscard]] Quat rotation() const noexcept { return turning_ ? turning_->plant.rotation() : Quat(1, 0, 0, 0); }

 private:
  /// Of a device that turns.
  struct Turning {
    SimulatedRotation plant;
    Quat target{1, 0, 0, 0}, from{1, 0, 0, 0};  // at the end of the tick, and at its start
    Vec3 targetSpeed{0};                        // rad/s
    Vec3 held_Nm{0};
    std::vector<Vec3> written_Nm;  // as written_
  };

  void beginTick() noexcept;
  void integrateSubstep(int substep) noexcept;
  void endTick() noexcept { felt_ = motorForce(kSubsteps - 1); }
  [[nodiscard]] std::size_t heldIn(int substep) const noexcept;
  [[nodiscard]] Vec3 motorForce(int substep) const noexcept { return written_[heldIn(substep)]; }
  void beginTurning() noexcept;
  void turn(int substep) noexcept;
  [[nodiscard]] Quat measuredRotation() const noexcept;
  void moveGripper() noexcept;

  DeviceInfo info_;
  Plant plant_;
  HandIntent& intent_;
  double period_;
  double substep_;          // s
  int delay_;               // substeps
  HandTarget target_;       // at the end of the tick
  HandTarget from_;         // at its start
  Vec3 targetVelocity_{0};  // m/s
  Vec3 held_{0};
  Vec3 felt_{0};               // by the motors at the end of the last tick
  std::vector<Vec3> written_;  // ring: the force of each tick, as far back as the delay reaches
  std::size_t newest_ = 0;
  std::optional<Turning> turning_;
  double fingerStiffness_, fingerDamping_;  // of the gripper, Nm/rad, Nms/rad
  double gripper_ = 0, wantedGripper_ = 0;  // rad
  double grip_Nm_ = 0;
  std::uint64_t tick_ = 0;
  bool started_ = false;
  bool stopped_ = false;
};

}  // namespace haptics
