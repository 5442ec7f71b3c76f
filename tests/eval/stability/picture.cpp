#include "tests/eval/stability/picture.h"

#include "haptic_server/device/presets.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/renderer.h"
#include "tests/eval/stability/limits.h"
#include "tests/eval/stability/methods.h"

namespace haptics::eval {
namespace {

/// Points (damping, stiffness), as long as the formula gives more than the picture shows.
template <class Limit>
Record curveOf(double most, Limit limit) {
  constexpr double kStep = 1.25, kNoDamping = 0.1, kLeast_N_per_m = 10;
  Record points = Record::array();
  for (double damping = kNoDamping; damping <= most; damping *= kStep) {
    const double k = limit(damping <= kNoDamping ? 0 : damping);
    if (k >= kLeast_N_per_m) points.push_back({damping, k});
  }
  return points;
}

Record describe(const DevicePreset& device) {
  constexpr double kMost = 100, kShort = 0.2;  // of what is said of no damping only
  const double most_N_per_m = device.maxStiffness_N_per_m;
  const auto loop = [&](double damping) {
    return SampledLoop{device.apparentMass_kg, device.viscousFriction_Ns_per_m, damping, kPeriod_s, kPeriod_s};
  };
  const double withFriction_N_per_m =
      frictionLimit_N_per_m(device.viscousFriction_Ns_per_m, device.coulombFriction_N, device.resolution_m, kPeriod_s);
  return {{"name", device.name},
          {"title", device.title},
          {"most_N_per_m", most_N_per_m},
          // Where it lies at its maker's stiffness (Diolaiti et al. 2006).
          {"region",
           {device.viscousFriction_Ns_per_m / (most_N_per_m * kPeriod_s),
            device.coulombFriction_N / (most_N_per_m * device.resolution_m)}},
          {"formulas",
           {curveOf(kMost, [&](double b) { return passiveLimit_N_per_m(loop(b)); }),
            curveOf(kShort, [&](double) { return withFriction_N_per_m; }),
            curveOf(kMost, [&](double b) { return delayLimit_N_per_m(loop(b)); }),
            curveOf(kMost, [&](double b) { return exactLimit_N_per_m(loop(b)); })}}};
}

}  // namespace

void drawStability(const std::vector<Record>& records, const std::filesystem::path& folder) {
  Record methods, devices;
  for (const MethodEntry& method : stabilityMethods())
    methods.push_back({{"name", method.name}, {"title", method.title}, {"note", method.note}});
  for (const DevicePreset& device : devicePresets()) devices.push_back(describe(device));
  drawFigure("stability", {{"records", records}, {"methods", methods}, {"devices", devices}}, folder / "stability");
}

}  // namespace haptics::eval
