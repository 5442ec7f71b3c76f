#pragma once

#include <cstdint>

#include "common/telemetry/device_reading.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

struct StepInput {
  std::uint64_t tick = 0;
  std::uint64_t time_ns = 0;  ///< Only passed on to telemetry.
  DevicePose device;
};

/// Goes over to another scene at a tick's start: contact and motion state is carried over by object id. An edit under
/// the stylus is felt without a step of the contact force: of the material, or a removal, by RateLimitedStiffness; a
/// short way of the object by RateLimitedPose. Where neither will do, and the force would step by more than a hand
/// notices, the contact is first faded out, for up to 0.25 s.
/// @return False while that lasts: the state stays with its scene, which must stay alive; call again at the next tick's
/// start, with this scene or a newer one.
[[nodiscard]] bool adoptScene(const ServoScene& next, HapticState& state, std::uint64_t tick) noexcept;

/// One servo tick (paper 3.2): (scene, state, input) -> (state, sample). No clock, socket, lock, allocation or device
/// inside; the server, the evaluation tools and replay run this same function, the server in its two halves, so that the
/// device need not wait for more than the first. `scene` is the one that `state` adopted last.
/// @return The tick's telemetry; `force.written` (N, world) is for the device. The counters of queue and loop, and what
/// the device's handle measured, are left to the loop.
/// @param added_N  By a client; null: nothing.
[[nodiscard]] TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                         const StepInput& input, const Vec3* added_N = nullptr) noexcept;

/// The half of hapticStep() that the device waits for, from its position to its force.
/// @param[in,out] result  Pass it as constructed, with what a client adds. Then `result.force.written` (N, world) is for the
/// device, the rest for finishStep().
/// @param cache  Triangles that a rehearsal computed ahead, which saves time and changes no bit; null: none.
void computeForce(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
                  ForceResult& result, const TriangleCache* cache = nullptr) noexcept;

/// The other half, once the force is written: bodies move, the observer takes the force into account, energies are
/// attributed, and the sample is filled.
[[nodiscard]] TelemetrySample finishStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                         const StepInput& input, const ForceResult& result) noexcept;

}  // namespace haptics
