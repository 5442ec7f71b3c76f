#include "haptic_server/device_settings.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>

#include "common/clock/monotonic.h"
#include "common/log/log.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/surface_limits_cache.h"

namespace haptics {
namespace {

/// The delay as the command line has it where that says more than the driver.
[[nodiscard]] DeviceInfo deviceInfoOf(const ServerOptions& options, DeviceInfo device) {
  if (options.deviceDelay_ms) device.delay_s = *options.deviceDelay_ms * 1e-3;
  return device;
}

}  // namespace

StepConfig stepConfigOf(const ServerOptions& options, const DeviceInfo& device, double rate_Hz) {
  return serverStepConfig(deviceInfoOf(options, device), rate_Hz, options.stabiliser);
}

DeviceLimits limitsOf(const ServerOptions& options, const DeviceInfo& device, const StepConfig& step, double rate_Hz) {
  const std::uint64_t began_ns = monotonicNow_ns();
  const auto [limits, searched] = SurfaceLimitsCache(SurfaceLimitsCache::userFolder())
                                      .find(deviceInfoOf(options, device), rate_Hz, options.stabiliser);
  std::array<char, 128> said{};
  std::snprintf(said.data(), said.size(), "surfaces are felt with at most %.5g N/m and %.3g Ns/m: %s in %.0f ms",
                limits.stiffness_N_per_m, limits.damping_Ns_per_m, searched ? "found" : "read",
                static_cast<double>(monotonicNow_ns() - began_ns) * 1e-6);
  logInfo(said.data());
  if (limits.stiffness_N_per_m == 0) {
    logWarning(
        "no surface is felt: by simulation this device comes to rest on no wall at this rate and delay; less delay, a "
        "higher rate or the stabiliser may help");
  }
  return {step.positionStep_m,
          step.stableLateral_N_per_m,
          step.period_s,
          limits.stiffness_N_per_m,
          limits.damping_Ns_per_m,
          limits.torsion_Nm_per_rad,
          device.gripper.maxMoment_Nm > 0 ? device.gripper.maxStiffness_Nm_per_rad
                                          : std::numeric_limits<double>::infinity(),
          1,
          options.stabiliser};
}

DeviceLimits ofBoth(const DeviceLimits& first, const DeviceLimits& second) {
  return {.encoderStep_m = std::max(first.encoderStep_m, second.encoderStep_m),
          .stableLateral_N_per_m = std::min(first.stableLateral_N_per_m, second.stableLateral_N_per_m),
          .period_s = first.period_s,
          .stiffest_N_per_m = std::min(first.stiffest_N_per_m, second.stiffest_N_per_m),
          .maxDamping_Ns_per_m = std::min(first.maxDamping_Ns_per_m, second.maxDamping_Ns_per_m),
          .stiffestTorsion_Nm_per_rad = first.stiffestTorsion_Nm_per_rad,  // the second hand holds no tool
          .stiffestGrip_Nm_per_rad = first.stiffestGrip_Nm_per_rad,
          .hands = first.hands + second.hands,
          .observed = first.observed && second.observed};
}

}  // namespace haptics
