#include "haptic_server/engine/step/two_hands.h"

#include <cstdint>

#include "haptic_server/engine/step/moving_bodies.h"

namespace haptics {

StepConfig perHandConfig(StepConfig config) noexcept {
  config.work_per_s /= 2;
  return config;
}

void followFirstHand(HapticState& second) noexcept {
  constexpr std::uint64_t kOwnDents = std::uint64_t{1} << 63;
  second.motion.follows = true;
  second.denting.newest = kOwnDents;  // no edit takes them for those of the first hand
}

void finishSteps(const HandTick& first, const HandTick& second, TelemetrySample& firstSample,
                 TelemetrySample& secondSample) noexcept {
  takePushes(first.state, second.state, second.result);
  firstSample = finishStep(first.scene, first.state, first.config, first.input, first.result);
  followMovedBodies(first.state, second.state, second.result);
  secondSample = finishStep(second.scene, second.state, second.config, second.input, second.result);
}

}  // namespace haptics
