#include "tests/eval/step_config.h"

#include "haptic_server/device/local_stability.h"
#include "haptic_server/device/simulated_device.h"

namespace haptics::eval {
namespace {

class IdleHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
};

}  // namespace

StepConfig stepConfigFor(const DevicePreset& device, double rate_Hz) {
  IdleHand idle;
  const SimulatedDevice simulated({device, HandPreset{}, 1 / rate_Hz, 0}, idle);
  StepConfig config;
  config.period_s = 1 / rate_Hz;
  config.maxForce_N = 1e9;
  config.positionStep_m = device.resolution_m;
  config.stableLateral_N_per_m = locallyStableStiffness_N_per_m(simulated.info(), config.period_s);
  return config;
}

}  // namespace haptics::eval
