#include "haptic_server/servo/stiffness_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/force/output_chain.h"
#include "haptic_server/force/spring_damper.h"
#include "haptic_server/force/velocity_estimator.h"
#include "haptic_server/servo/server_step_config.h"

namespace haptics {
namespace {

constexpr double kTime_s = 1.2;
constexpr double kJudged_s = 0.3;
constexpr double kLeastCycle_m = 20e-6;
/// Softer walls come to rest more slowly than is waited for.
constexpr double kLeast_N_per_m = 300;
/// Coming to rest is not judged where a thing would have to bounce for longer than that first.
constexpr double kTapHeight_m = 0.2e-3;

/// Lets the device go a little above the wall z = 0, with a constant push.
class LettingGo final : public HandIntent {
 public:
  LettingGo(double height_m, double push_N) : target_{{0, 0, height_m}, {0, 0, -push_N}} {}
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return target_; }

 private:
  HandTarget target_;
};

[[nodiscard]] DevicePreset presetOf(const DeviceInfo& device) {
  return {"",
          "",
          device.maxForce_N,
          device.maxStiffness_N_per_m,
          device.maxDamping_Ns_per_m,
          device.apparentMass_kg,
          device.viscousFriction_Ns_per_m,
          device.coulombFriction_N,
          device.resolution_m};
}

[[nodiscard]] bool rests(const DeviceInfo& device, const StepConfig& config, Stiffness wall, double height_m,
                         double push_N) {
  LettingGo hand(height_m, push_N);
  SimulatedDevice simulated({presetOf(device), HandPreset{}, config.period_s, device.delay_s}, hand);
  LeadObserver lead;
  if (config.lead) lead = LeadObserver(*config.lead, config.period_s);
  lead.reset({0, 0, height_m});
  VelocityEstimator velocity(config.period_s);
  velocity.reset({0, 0, height_m});
  const auto ticks = static_cast<std::uint64_t>(kTime_s / config.period_s);
  const auto judged = static_cast<std::uint64_t>(kJudged_s / config.period_s);
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const Vec3 measured = simulated.read(tick).position;
    const Vec3 hip = lead.active() ? lead.follow(measured) : measured;
    const double speed = (lead.active() ? lead.velocity() : velocity.update(measured)).z;
    const bool inside = hip.z < 0;
    const SpringDamper felt = springDamper(std::max(0.0, -hip.z), speed, inside ? wall : Stiffness{});
    const Vec3 force = limitMagnitude({0, 0, felt.spring + felt.damping}, config.maxForce_N);
    if (lead.active()) lead.note(force, {0, 0, inside ? 1 : 0}, wall.spring_N_per_m);
    simulated.write(force);
    if (ticks - tick > judged) continue;
    least = std::min(least, simulated.plant().position().z);
    most = std::max(most, simulated.plant().position().z);
  }
  constexpr double kRounding = 1 + 1e-6;
  return most - least <= kRounding * std::max(2 * device.resolution_m, kLeastCycle_m);
}

[[nodiscard]] bool rests(const DeviceInfo& device, const StepConfig& config, Stiffness wall) {
  const double gentle_N = device.coulombFriction_N + 0.25;
  return rests(device, config, wall, device.resolution_m, gentle_N) &&
         rests(device, config, wall, device.resolution_m, 2 * gentle_N) &&
         rests(device, config, wall, kTapHeight_m, 2 * gentle_N);
}

/// Largest value up to which all that were tried hold; the least, where that does not.
template <class Holds>
[[nodiscard]] double critical(double least, double most, Holds holds) {
  constexpr double kClimb = 1.5, kClose = 1.05;
  double stable = least, unstable = least * kClimb;
  while (unstable < most && holds(unstable)) {
    stable = unstable;
    unstable *= kClimb;
  }
  while (unstable / stable > kClose) {
    const double middle = std::sqrt(stable * unstable);
    (holds(middle) ? stable : unstable) = middle;
  }
  return stable;
}

[[nodiscard]] StepConfig configFor(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  constexpr double kFastest_Hz = 4000;
  StepConfig config = serverStepConfig(device, std::min(rate_Hz, kFastest_Hz));
  if (!stabilised) config.lead.reset();
  return config;
}

}  // namespace

double criticalStiffness_N_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const StepConfig config = configFor(device, rate_Hz, stabilised);
  constexpr double kMost_N_per_m = 200e3;
  return critical(kLeast_N_per_m, kMost_N_per_m, [&](double k) { return rests(device, config, {k, 0}); });
}

double criticalDamping_Ns_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised, double stiffest_N_per_m) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const StepConfig config = configFor(device, rate_Hz, stabilised);
  const double softest_N_per_m = std::min(kLeast_N_per_m, stiffest_N_per_m);
  const auto holds = [&](double b) {
    return rests(device, config, {softest_N_per_m, b}) && rests(device, config, {stiffest_N_per_m, b});
  };
  constexpr double kLeast_Ns_per_m = 0.1, kMost_Ns_per_m = 200;
  return holds(kLeast_Ns_per_m) ? critical(kLeast_Ns_per_m, kMost_Ns_per_m, holds) : 0;
}

}  // namespace haptics
