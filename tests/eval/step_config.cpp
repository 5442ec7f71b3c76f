#include "tests/eval/step_config.h"

#include "haptic_server/device/local_stability.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/server_step_config.h"

namespace haptics::eval {
namespace {

class IdleHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
};

DeviceInfo infoOf(const DevicePreset& device, double rate_Hz, double delay_s) {
  IdleHand idle;
  return SimulatedDevice({device, HandPreset{}, 1 / rate_Hz, delay_s}, idle).info();
}

}  // namespace

StepConfig stepConfigFor(const DevicePreset& device, double rate_Hz) {
  StepConfig config;
  config.period_s = 1 / rate_Hz;
  config.maxForce_N = 1e9;
  config.positionStep_m = device.resolution_m;
  config.stableLateral_N_per_m = locallyStableStiffness_N_per_m(infoOf(device, rate_Hz, 0), config.period_s);
  return config;
}

StepConfig serverConfigFor(const DevicePreset& device, double rate_Hz, double delay_s) {
  StepConfig config = serverStepConfig(infoOf(device, rate_Hz, delay_s), rate_Hz);
  config.rise_s = 0;
  return config;
}

DevicePreset withoutRotation(DevicePreset device) {
  device.rotation = {};
  return device;
}

}  // namespace haptics::eval
