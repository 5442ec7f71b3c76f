#include "haptic_server/servo/stiffness_limit.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "haptic_server/device/presets.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/servo/settling.h"
#include "haptic_server/servo/stability_search.h"

namespace haptics {
namespace {

/// A firmer hand hides what a lighter one shows.
constexpr std::array<std::string_view, 2> kJudgedHands{"none", "light"};

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

[[nodiscard]] StepConfig configFor(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  StepConfig config = serverStepConfig(device, rate_Hz);
  config.rise_s = 0;
  if (!stabilised) config.lead.reset();
  return config;
}

/// Presses a device on walls, in every hand by which stiffness is judged and in every way.
class WallPresses {
 public:
  WallPresses(const DeviceInfo& device, double rate_Hz, bool stabilised)
      : config_(configFor(device, rate_Hz, stabilised)) {
    for (const std::string_view name : kJudgedHands) {
      const HandPreset hand = findHandPreset(name).value();
      for (const PressKind& kind : pressKinds()) {
        presses_.push_back({presetOf(device), hand, config_.period_s, device.delay_s, kind.force_N, kind.tap_m_per_s});
      }
    }
  }

  [[nodiscard]] bool allComeToRestOn(Stiffness wall) const {
    std::vector<PressTrial> trials;
    for (const Press& press : presses_) {
      trials.push_back({press, std::make_unique<ProductionStep>(sceneOf(wall), config_)});
    }
    return allComeToRest(trials, pressedWall().place);
  }

 private:
  [[nodiscard]] static ServoScene sceneOf(Stiffness wall) {
    ServoScene scene;
    scene.revision = 1;
    ServoObject& object = scene.objects.emplace_back();
    object.id = 1;
    object.surface = pressedWall().surface;
    object.pose = pressedWall().pose;
    object.stiffness_N_per_m = wall.spring_N_per_m;
    object.damping_Ns_per_m = wall.damping_Ns_per_m;
    return scene;
  }

  StepConfig config_;
  std::vector<Press> presses_;
};

}  // namespace

double criticalStiffness_N_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const WallPresses presses(device, rate_Hz, stabilised);
  return largestStable(kStiffnessSearch, [&](double k) { return presses.allComeToRestOn({k, 0}); });
}

double criticalDamping_Ns_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised, double stiffest_N_per_m) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const WallPresses presses(device, rate_Hz, stabilised);
  constexpr double kSoft_N_per_m = 300;
  const double softest_N_per_m = std::min(kSoft_N_per_m, stiffest_N_per_m);
  constexpr StabilitySearch kDampingSearch{.least = 0.1, .most = 200, .climb = 1.5};
  return largestStable(kDampingSearch, [&](double b) {
    return presses.allComeToRestOn({softest_N_per_m, b}) && presses.allComeToRestOn({stiffest_N_per_m, b});
  });
}

}  // namespace haptics
