#include "haptic_server/servo/server_step_config.h"

#include "haptic_server/device/local_stability.h"

namespace haptics {
namespace {

// Chosen with haptic_eval stability: of those tried (60 to 140 Hz, 0.75 to 2 ms, 0.4 to 1 of the mass) they leave the most
// to every device preset when mass, friction and delay are not what the data sheet says.

/// Of the mass in the data sheet: a device that is lighter than the observer thinks costs more than one that is heavier.
constexpr double kTrustedMass = 0.62;
constexpr double kBandwidth_Hz = 82;
/// At higher rates the estimate may follow faster without more noise.
constexpr double kFast_Hz = 4000;
constexpr double kFastBandwidth_Hz = 140;

/// Of the force after attach: long enough to let go of a device that pushes where nothing should.
constexpr double kRise_s = 0.5;

}  // namespace

LeadSettings leadFor(const DeviceInfo& device, double rate_Hz) noexcept {
  LeadSettings settings;
  settings.mass_kg = kTrustedMass * device.apparentMass_kg;
  settings.viscousFriction_Ns_per_m = device.viscousFriction_Ns_per_m;
  settings.delay_s = device.delay_s;
  settings.bandwidth_Hz = rate_Hz >= kFast_Hz ? kFastBandwidth_Hz : kBandwidth_Hz;
  return settings;
}

StepConfig serverStepConfig(const DeviceInfo& device, double rate_Hz) noexcept {
  StepConfig config{.period_s = 1 / rate_Hz,
                    .maxForce_N = device.maxForce_N,
                    .positionStep_m = device.resolution_m,
                    .stableLateral_N_per_m = locallyStableStiffness_N_per_m(device, 1 / rate_Hz)};
  config.lead = leadFor(device, rate_Hz);
  config.rise_s = kRise_s;
  return config;
}

}  // namespace haptics
