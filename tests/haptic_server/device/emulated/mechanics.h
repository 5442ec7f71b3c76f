#pragma once

#include <cstdint>

#include "haptic_server/device/plant.h"
#include "haptic_server/device/presets.h"

namespace haptics::test {

/// The moving parts of an emulated device in a simulated hand that wanders about and presses down now and then. Device
/// frame turned upright: z is up, the origin is the middle of the workspace.
class Mechanics {
 public:
  explicit Mechanics(const DevicePreset& device);

  /// Up to `now_ns`, in steps of 50 us, the motors pushing with a force (N).
  void advance(std::uint64_t now_ns, Vec3 motor_N);
  [[nodiscard]] Vec3 position() const { return plant_.position(); }
  [[nodiscard]] static Vec3 intended(double time_s);

 private:
  Plant plant_;
  std::uint64_t time_ns_ = 0;
  std::uint64_t began_ns_ = 0;
};

}  // namespace haptics::test
