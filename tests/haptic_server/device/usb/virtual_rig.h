#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/device/usb/falcon.h"
#include "haptic_server/device/usb/usb_device.h"
#include "haptic_server/device/usb/wooden_haptics.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/servo/sample_wait.h"
#include "tests/haptic_server/device/emulated/falcon_model.h"
#include "tests/haptic_server/device/emulated/wooden_model.h"
#include "tests/haptic_server/device/usb/some_firmware.h"
#include "tests/haptic_server/device/usb/virtual_usb.h"

namespace haptics::test {

inline constexpr std::uint64_t kMs = 1'000'000;

inline std::unique_ptr<UsbProtocol> protocolFor(const FalconModel&, std::optional<FalconFirmware> firmware) {
  return std::make_unique<Falcon>(DeviceCalibration{}, std::move(firmware));
}
inline std::unique_ptr<UsbProtocol> protocolFor(const WoodenModel&, const std::optional<FalconFirmware>&) {
  return std::make_unique<WoodenHaptics>(DeviceCalibration{});
}

/// Driver, servo step and emulated device with its hand in closed loop, in virtual time: every timing is exact.
/// A server's device and servo threads on one time line, with a plate of 0.2 m under the middle of the workspace.
template <class Model>
class Rig {
 public:
  explicit Rig(std::optional<FalconFirmware> firmware = someFirmware()) {
    bus.plugged.push_back({{1, 2, "1-1", "SIM00001"}, &model});
    device.emplace(bus, protocolFor(model, std::move(firmware)),
                   UsbDeviceSettings{.wanted = "",
                                     .info = [this](const std::string& line) { log.push_back(line); },
                                     .warning = [this](const std::string& line) { log.push_back(line); }});
    config.maxForce_N = device->info().maxForce_N;
    state.emplace(config);
    const TriMesh plate = makeBox(Vec3(0.2, 0.2, 0.1), 2).value();
    scene.objects.push_back({1, buildCollisionMesh(plate.vertices, plate.triangles),
                             Pose{Quat(1, 0, 0, 0), Vec3(0, 0, -0.01)}, 800, 0.5, false});
    adopted = adoptScene(scene, *state, 0);
    bus.nextTime_ns = servoDue_ns_ = servoWakes_ns_ = bus.now_ns;
    bus.onTime = [this](std::uint64_t now_ns) { return pass(now_ns); };
  }

  /// Runs until `done`, which is asked each 0.1 ms; false when it never was in `limit_s` seconds.
  bool until(std::function<bool()> done, double limit_s = 20) {
    done_ = std::move(done);
    quit_ = ok_ = false;
    deadline_ns_ = bus.now_ns + static_cast<std::uint64_t>(limit_s * 1e9);
    device->drive(quit_);
    return ok_;
  }
  bool feeling() const { return sample.fault == Fault::kNone && sample.deviceState == DeviceState::kReady; }
  bool pressing() const { return feeling() && glm::length(sample.force.written) > 0.3 && model.motorsOn(); }

  VirtualUsb bus;
  Model model;
  std::vector<std::string> log;
  std::optional<UsbDevice> device;
  StepConfig config{.period_s = 1e-3};
  std::optional<HapticState> state;
  ServoScene scene;
  bool adopted = false;
  TelemetrySample sample;
  std::uint64_t tick = 0;
  bool servoAlive = true;
  /// Wakes up so much later than it should, at most: another time in each tick.
  std::uint64_t servoJitter_ns = 0;
  /// The servo's beat, later by so much from now on.
  void delayServo(std::uint64_t by_ns) { servoDue_ns_ += by_ns; }
  bool motorsWereOn = false;  ///< At the last instant before `until` returned, which switches them off.

 private:
  std::uint64_t pass(std::uint64_t now_ns) {
    model.advance(now_ns);
    motorsWereOn = model.motorsOn();
    if (now_ns >= servoWakes_ns_) servoWakes(now_ns);
    if (now_ns >= asks_ns_) {
      if (!quit_ && done_ && done_()) quit_ = ok_ = true;
      if (now_ns > deadline_ns_) quit_ = true;
      asks_ns_ = now_ns - now_ns % (kMs / 10) + kMs / 10;
    }
    return std::min(asks_ns_, servoWakes_ns_);
  }

  /// As ServoLoop::run().
  void servoWakes(std::uint64_t now_ns) {
    if (sampleWait_.shouldWait(device->hasNewSample(), now_ns - std::min(now_ns, servoDue_ns_))) {
      servoWakes_ns_ = now_ns + sampleWait_.step_ns();
      return;
    }
    if (servoAlive) {
      sample = hapticStep(scene, *state, config, {tick, now_ns, device->read(tick)});
      ++tick;
      device->write(sample.force.written);
    }
    servoDue_ns_ += kMs;
    servoWakes_ns_ = servoDue_ns_;
    if (servoJitter_ns > 0) servoWakes_ns_ += random_() % servoJitter_ns;
  }

  SampleWait sampleWait_{kMs};
  std::mt19937 random_{7};
  std::uint64_t servoDue_ns_ = 0, servoWakes_ns_ = 0, asks_ns_ = 0;

  std::function<bool()> done_;
  std::atomic<bool> quit_{false};
  bool ok_ = false;
  std::uint64_t deadline_ns_ = 0;
};
/// For typed tests of both devices.
using Models = ::testing::Types<FalconModel, WoodenModel>;
struct ModelNames {
  template <class Model>
  static std::string GetName(int) {
    return std::is_same_v<Model, FalconModel> ? "Falcon" : "WoodenHaptics";
  }
};

}  // namespace haptics::test
