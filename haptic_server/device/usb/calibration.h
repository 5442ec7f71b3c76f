#pragma once

#include <array>
#include <optional>

#include "common/maths/rotation.h"
#include "common/maths/vec.h"
#include "common/telemetry/handle_reading.h"

namespace haptics {

/// How one device stands in the world, and what its motors do: what a calibration file may say. What it leaves open is
/// the driver's default.
struct DeviceCalibration {
  std::optional<Vec3> worldPosition{};     ///< Metres: where the middle of its workspace is in the world.
  std::optional<double> turn_rad{};        ///< About the world's z: where its user sits. 0: at -y, looking along +y.
  std::optional<double> workspaceScale{};  ///< Metres in the world per metre of the hand; felt stiffness grows with it.
  std::optional<double> maxForce_N{};      ///< Below the device's own limit.
  std::optional<double> forceScale{};      ///< Of every force, 0 to 1.
  /// Falcon: motor units per newton metre. Public sources differ from 2,400 to 10,000; less is weaker.
  std::optional<double> motorUnitsPerNm{};
  /// Axes that turn the other way than the driver thinks, encoder and motor both.
  std::array<bool, 3> reversed{};
  /// -1 for each of these, else 1.
  [[nodiscard]] Vec3 sense() const noexcept {
    return {reversed[0] ? -1 : 1, reversed[1] ? -1 : 1, reversed[2] ? -1 : 1};
  }
};

/// From the device's frame to the world and back, for positions and rotations, forces and torques.
class Placement {
 public:
  /// `upright` turns device axes to world axes for a user at -y; `centre_m` is the middle of the workspace, device frame.
  Placement(const DeviceCalibration& calibration, Quat upright, Vec3 centre_m) noexcept
      : rotation_(rotationBy(Vec3(0, 0, calibration.turn_rad.value_or(0))) * upright),
        centre_(centre_m),
        world_(calibration.worldPosition.value_or(Vec3(0, 0, 0.05))),
        scale_(calibration.workspaceScale.value_or(1)) {}

  [[nodiscard]] Vec3 toWorld(Vec3 position) const noexcept {
    return world_ + scale_ * (rotation_ * (position - centre_));
  }
  [[nodiscard]] Quat toWorld(Quat rotation) const noexcept { return rotation_ * rotation * glm::conjugate(rotation_); }
  [[nodiscard]] HandleReading toWorld(HandleReading handle) const noexcept {
    handle.velocity = scale_ * (rotation_ * handle.velocity);
    handle.appliedForce_N = rotation_ * handle.appliedForce_N;
    return handle;
  }
  [[nodiscard]] Vec3 toDevice(Vec3 position) const noexcept {
    return centre_ + glm::conjugate(rotation_) * (position - world_) / scale_;
  }
  /// Of a torque likewise.
  [[nodiscard]] Vec3 forceToDevice(Vec3 force) const noexcept { return glm::conjugate(rotation_) * force; }
  [[nodiscard]] double scale() const noexcept { return scale_; }

 private:
  Quat rotation_;
  Vec3 centre_, world_;
  double scale_;
};

}  // namespace haptics
