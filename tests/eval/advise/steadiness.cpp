#include "tests/eval/advise/steadiness.h"

#include <algorithm>
#include <limits>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/step_config.h"

namespace haptics::eval {
namespace {

constexpr double kPush_N = 1;
constexpr double kAbove_m = 0.001;

/// Begins above the place, then pushes into it and does nothing else.
class PressingHand final : public HandIntent {
 public:
  PressingHand(Vec3 place, Vec3 normal, const HandPreset& hand)
      : begin_{place + normal * kAbove_m, Vec3(0)}, press_{place, Vec3(0)} {
    if (hand.stiffness_N_per_m > 0) {
      press_.position -= normal * (kPush_N / hand.stiffness_N_per_m);
    } else {
      press_.push_N = normal * -kPush_N;
    }
  }
  HandTarget next(double dt_s, Vec3 /*felt_N*/) noexcept override { return dt_s == 0 ? begin_ : press_; }

 private:
  HandTarget begin_;
  HandTarget press_;
};

}  // namespace

Steadiness restOn(const ServoScene& scene, Vec3 place, Vec3 normal, const DevicePreset& device, const HandPreset& hand,
                  double rate_Hz) {
  constexpr double kTime_s = 2;
  constexpr double kJudged_s = 0.3;
  constexpr double kMinCycle_m = 20e-6;
  PressingHand pressing(place, normal, hand);
  SimulatedDevice simulated({withoutRotation(device), hand, 1 / rate_Hz, 0}, pressing);
  const StepConfig config = serverConfigFor(device, rate_Hz);
  HapticState state(config);
  (void)adoptScene(scene, state, 0);  // the first is always taken
  const auto ticks = static_cast<std::uint64_t>(kTime_s * rate_Hz);
  Steadiness result;
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const TelemetrySample sample = hapticStep(scene, state, config, {tick, 0, simulated.read(tick)});
    simulated.write(sample.force.written);
    if (static_cast<double>(ticks - tick) > kJudged_s * rate_Hz) continue;
    result.touching = result.touching && sample.object != 0;
    least = std::min(least, sample.penetration_m);
    most = std::max(most, sample.penetration_m);
  }
  result.cycle_um = (most - least) * 1e6;
  constexpr double kRounding = 1 + 1e-6;
  result.steady = result.touching && most - least <= kRounding * std::max(2 * device.resolution_m, kMinCycle_m);
  return result;
}

}  // namespace haptics::eval
