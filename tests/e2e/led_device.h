#pragma once

#include <atomic>

#include "common/mailbox/triple_buffer.h"
#include "haptic_server/device/device.h"
#include "haptic_server/device/presets.h"

namespace haptics::e2e {

/// A device that a test leads from place to place. It goes straight there at kSpeed_m_per_s and stays, whatever force it is
/// given. It tells of the mechanics of a preset.
class LedDevice final : public Device {
 public:
  static constexpr double kSpeed_m_per_s = 0.2;

  /// Begins at rest at `place` (world, metres).
  LedDevice(const DevicePreset& preset, double period_s, Vec3 place);

  /// One thread at a time; not the servo's, as is rests().
  void lead(Vec3 place);
  /// Is the device where it was led to last?
  [[nodiscard]] bool rests() const noexcept { return arrived_.load() == led_; }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override;
  void write(Vec3 /*force_N*/) noexcept override {}
  void stop() noexcept override {}

 private:
  struct Target {
    Vec3 place{0};
    std::uint64_t number = 0;
  };
  DeviceInfo info_;
  double period_s_;
  std::uint64_t led_ = 0;
  TripleBuffer<Target> newest_;
  std::atomic<std::uint64_t> arrived_{0};
  // The servo's.
  Target target_;
  Vec3 position_;
  std::uint64_t tick_ = 0;
};

/// ServerApp::start() called by this thread gets the device, which outlives the server, instead of the one in its options.
/// It is linked instead of haptic_server/attached_device.cpp.
void attachNext(LedDevice& device);

}  // namespace haptics::e2e
