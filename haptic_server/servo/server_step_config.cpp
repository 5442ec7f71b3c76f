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
  double hardBandwidth_Hz;  ///< At any rate.
};
constexpr double kFast_Hz = 4000;

/// Up to the maker's stiffness an observer that follows slowly is steady enough, and tells little of the encoder's steps.
/// From kHard of it on only a fast one is.
constexpr Look kUsual{1.0, 68, 140, 217};
constexpr double kHard = 2.3;
/// All lead along the normal together, whatever part of it the delay takes: enough where the delay is a period longer than
/// was told, not too much where it is a period shorter.
constexpr double kWholeLead_s = 2.0e-3;

/// Where friction is, that holds what the steps of the encoder do to the force, a slow one is steady enough on hard surfaces
/// too, and bears more of them.
constexpr Look kHeld{1.0, 82, 140, 82};

/// N by which one step of the encoder changes the force at the maker's stiffness. Above it the encoder has to be smoothed
/// on every surface, and the lead is longer to make up for that.
constexpr double kCoarse_N = 0.1;
constexpr Look kCoarse{0.8, 95, 140, 95};
constexpr double kCoarseContactLead_s = 1.95e-3;

/// Ramp of the force after attach: long enough to let go of a device that pushes where nothing should.
constexpr double kRise_s = 0.5;

/// At three times the maker's stiffness, does a third of the friction still hold what a step of the encoder does at rest,
/// K <= 2 f_c / step (Abbott & Okamura 2005), and the friction an oscillation (locallyStableStiffness_N_per_m())?
[[nodiscard]] bool isHeld(const DeviceInfo& device, double rate_Hz) noexcept {
  const double stiffness_N_per_m = 3 * device.maxStiffness_N_per_m;
  return 2 * device.coulombFriction_N / 3 >= stiffness_N_per_m * device.resolution_m &&
         locallyStableStiffness_N_per_m(device, 1 / rate_Hz) >= stiffness_N_per_m;
}

}  // namespace

ObserverSettings observerFor(const DeviceInfo& device, double rate_Hz) noexcept {
  const double makers_N_per_m = device.maxStiffness_N_per_m;
  const bool coarse = makers_N_per_m * device.resolution_m > kCoarse_N;
  const Look& look = coarse ? kCoarse : isHeld(device, rate_Hz) ? kHeld : kUsual;
  ObserverSettings settings;
  settings.mass_kg = look.trustedMass * device.apparentMass_kg;
  settings.viscousFriction_Ns_per_m = device.viscousFriction_Ns_per_m;
  settings.delay_s = device.delay_s;
  settings.bandwidth_Hz = rate_Hz >= kFast_Hz ? look.fastBandwidth_Hz : look.bandwidth_Hz;
  settings.hardBandwidth_Hz = std::max(look.hardBandwidth_Hz, settings.bandwidth_Hz);
  if (makers_N_per_m > 0) {
    settings.softUpTo_N_per_m = makers_N_per_m;
    settings.hardFrom_N_per_m = kHard * makers_N_per_m;
  } else {
    settings.bandwidth_Hz = settings.hardBandwidth_Hz;  // which surface is hard for it is not known
  }
  settings.contactLead_s =
      coarse ? kCoarseContactLead_s : std::max(0.0, kWholeLead_s - (device.delay_s + 0.5 / rate_Hz));
  return settings;
}

StepConfig serverStepConfig(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  StepConfig config{.period_s = 1 / rate_Hz,
                    .maxForce_N = device.maxForce_N,
                    .positionStep_m = device.resolution_m,
                    .stableLateral_N_per_m = locallyStableStiffness_N_per_m(device, 1 / rate_Hz)};
  if (stabilised) config.observer = observerFor(device, rate_Hz);
  if (device.rotation.isSensed) {
    config.rotation = {.radius_m = gyration_m(device), .maxTorque_Nm = device.rotation.maxTorque_Nm};
    if (stabilised) config.rotation.observer = observerFor(rotationAsTranslation(device), rate_Hz);
  }
  config.maxGrip_Nm = device.gripper.maxMoment_Nm;
  config.rise_s = kRise_s;
  return config;
}

}  // namespace haptics
