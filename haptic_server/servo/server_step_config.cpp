#include "haptic_server/servo/server_step_config.h"

#include <algorithm>

#include "haptic_server/device/local_stability.h"

namespace haptics {
namespace {

/// How the observer looks at a kind of device. Chosen with haptic_eval stability: they leave the most to every device preset
/// when mass, friction and delay are not what the data sheet says, while the force is no more than 1.5 times as far off as
/// without.
struct Look {
  double trustedMass;  ///< Of the mass in the data sheet.
  double bandwidth_Hz;
  double fastBandwidth_Hz;  ///< At kFast_Hz and above, where it may follow faster without more noise.
};
constexpr double kFast_Hz = 4000;

/// Of little stiffness and mass: a spring on them is felt nearly without an error, so that steps of the encoder must not be.
constexpr Look kSoft{0.62, 82, 140};
constexpr double kSoftContactLead_s = 1.25e-3;

/// What comes after errs less, since it is late by less and needs not believe the mass; but it tells more of the encoder.
/// All of its lead along the normal together is as long as kWholeLead_s, whatever part of it the delay takes: enough where
/// the delay is a period longer than was told, not too much where it is a period shorter.
constexpr Look kStiff{1.0, 217, 217};
constexpr double kStiff_N_per_m = 2000;  // by the maker
constexpr double kWholeLead_s = 2.0e-3;

/// N by which one step of the encoder changes the force at the maker's stiffness. Above it a stiff device's encoder has to
/// be smoothed more, and the lead is longer to make up for that.
constexpr double kCoarse_N = 0.1;
constexpr Look kCoarse{0.8, 95, 140};
constexpr double kCoarseContactLead_s = 1.95e-3;

/// Of the force after attach: long enough to let go of a device that pushes where nothing should.
constexpr double kRise_s = 0.5;

}  // namespace

LeadSettings leadFor(const DeviceInfo& device, double rate_Hz) noexcept {
  const bool stiff = device.maxStiffness_N_per_m >= kStiff_N_per_m;
  const bool coarse = stiff && device.maxStiffness_N_per_m * device.resolution_m > kCoarse_N;
  const Look& look = coarse ? kCoarse : stiff ? kStiff : kSoft;
  LeadSettings settings;
  settings.mass_kg = look.trustedMass * device.apparentMass_kg;
  settings.viscousFriction_Ns_per_m = device.viscousFriction_Ns_per_m;
  settings.delay_s = device.delay_s;
  settings.bandwidth_Hz = rate_Hz >= kFast_Hz ? look.fastBandwidth_Hz : look.bandwidth_Hz;
  settings.contactLead_s = coarse  ? kCoarseContactLead_s
                           : stiff ? std::max(0.0, kWholeLead_s - (device.delay_s + 0.5 / rate_Hz))
                                   : kSoftContactLead_s;
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
