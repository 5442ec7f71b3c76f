#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <optional>

#include "common/error/error.h"
#include "common/telemetry/hand_command.h"
#include "haptic_server/device/device.h"
#include "haptic_server/device/wrench_follower.h"

namespace haptics {

/// A device whose workspace clients and its own hand move while it is felt. A handle at p, turned by q from upright, is in the
/// world at
///   offset + scale R p,   turned by   R q R^-1 A,
/// R the workspace's rotation; scale 1, offset 0, R and A the identity at start. While a button of the clutch is pressed the pose stays
/// where it was, and offset and A become such that the pose goes on from there once the button is let go (indexing). What the
/// pressed buttons are bound to is status.actions, by which the step takes the force away, or holds a body. A change of scale
/// and rotation leaves the pose likewise.
///
/// A force F of the world is R^-1 F / max(1, scale) on the hand. Where scale > 1 the hand feels the impedance that it felt at scale 1,
/// and moves in the world as its mass does: what is known of its stability holds. Where it is below, surfaces are softer.
///
/// Clients also add a wrench to the scene's, as does the border of a bubble (Dominjon et al. 2005): a hand that is d outside of it is
/// pushed back by 50 N/m, and its workspace moves outward at 0.1 m/s (d / 20 mm)^3, at most 0.1 m/s.
/// Deviation: less by the part of 1 N with which the scene pushes back. Else the world would be driven into the hand through a
/// surface, and a light hand, which gives way late, would swing on it.
class MovableWorkspace final : public Device {
 public:
  static constexpr double kGlide_m_per_s = 0.1;

  /// The device outlives it.
  MovableWorkspace(Device& device, double period_s) noexcept
      : device_(device), period_s_(period_s), wrench_(period_s) {}

  /// From the next read() on; one thread besides the servo's. Refused: commands come faster than the servo takes them.
  [[nodiscard]] Result<void> move(const WorkspaceCommand& command);
  /// Added to what the scene gives the hand (DeviceReading::added); the same thread.
  void add(const Wrench& wrench) noexcept { wrench_.command(wrench); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return device_.info(); }
  [[nodiscard]] bool hasNewSample() noexcept override { return device_.hasNewSample(); }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override;
  void writeTorque(Vec3 torque_Nm) noexcept override { device_.writeTorque(toDevice(torque_Nm)); }
  void writeGrip(double moment_Nm) noexcept override { device_.writeGrip(moment_Nm); }
  void write(Vec3 force_N) noexcept override {
    written_N_ = force_N;
    device_.write(isMoved_ ? toDevice(force_N) / shrink() : force_N);
  }
  void follow(const ExplorationPlan* plan) noexcept override { device_.follow(plan); }
  void stop() noexcept override { device_.stop(); }

 private:
  struct Placed {
    Vec3 position;
    Quat rotation;
  };

  [[nodiscard]] Placed place(const DeviceReading& reading) const noexcept;
  /// So that the reading is there.
  void anchor(const DeviceReading& reading, const Placed& there) noexcept;
  void take(const WorkspaceCommand& command, const DeviceReading& reading) noexcept;
  void moveClutch(const DeviceReading& reading) noexcept;
  void glide() noexcept;
  void passBorder(DeviceReading& reading) noexcept;
  [[nodiscard]] Vec3 toDevice(Vec3 v) const noexcept { return isMoved_ ? glm::conjugate(rotation_) * v : v; }
  [[nodiscard]] double shrink() const noexcept { return scale_ > 1 ? scale_ : 1; }

  Device& device_;
  const double period_s_;
  boost::lockfree::spsc_queue<WorkspaceCommand, boost::lockfree::capacity<64>> commands_;
  WrenchFollower wrench_;
  // The servo's.
  bool isMoved_ = false;  // a command came
  std::uint32_t clutchButtons_ = 0, graspButtons_ = 0, markButtons_ = 0, nextToolButtons_ = 0;
  Vec3 offset_{0};
  double scale_ = 1;
  Quat rotation_{1, 0, 0, 0}, aligned_{1, 0, 0, 0};
  std::optional<Vec3> glidesTo_;
  Bubble bubble_;
  Vec3 border_N_{0};  // by which it pushes the hand; world, as written_N_
  Vec3 written_N_{0};
  std::optional<Placed> held_;  // while the clutch is
};

}  // namespace haptics
