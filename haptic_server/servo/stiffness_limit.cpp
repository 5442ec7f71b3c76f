#include "haptic_server/servo/stiffness_limit.h"

#include <algorithm>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

#include "haptic_server/device/presets.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/servo/settling.h"
#include "haptic_server/servo/stability_search.h"

namespace haptics {
namespace {

[[nodiscard]] StepConfig configFor(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  StepConfig config = serverStepConfig(device, rate_Hz, stabilised);
  config.rise_s = 0;
  return config;
}

/// Presses a device on walls, in every hand by which stiffness is judged and in every way.
class WallPresses {
 public:
  WallPresses(const DeviceInfo& device, double rate_Hz, bool stabilised)
      : device_(presetOf(device)), delay_s_(device.delay_s), config_(configFor(device, rate_Hz, stabilised)) {
    device_.rotation = {};  // a point does not feel it
  }

  [[nodiscard]] bool allComeToRestOn(Stiffness wall) const {
    auto light = std::async(std::launch::async, [&] { return allComeToRestOn(wall, "light"); });
    const bool none = allComeToRestOn(wall, "none");
    return light.get() && none;
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

  [[nodiscard]] bool allComeToRestOn(Stiffness wall, std::string_view hand) const {
    std::vector<PressTrial> trials;
    for (const PressKind& kind : pressKinds()) {
      const Press press{device_,         findHandPreset(hand).value(), config_.period_s, delay_s_, kind.force_N,
                        kind.tap_m_per_s};
      trials.push_back({press, std::make_unique<ProductionStep>(sceneOf(wall), config_)});
    }
    return allComeToRest(trials, pressedWall().place);
  }

  DevicePreset device_;
  double delay_s_;
  StepConfig config_;
};

/// The largest that is stable, of which kStabilityMargin is stable as well: a band of unstable values may lie between
/// those that a search tries.
template <class IsStable>
[[nodiscard]] double critical(StabilitySearch search, IsStable isStable) {
  std::map<double, bool> tried;
  const auto isKnownStable = [&](double value) {
    const auto [at, isNew] = tried.try_emplace(value);
    if (isNew) at->second = isStable(value);
    return at->second;
  };
  double largest = largestStable(search, isKnownStable);
  while (largest > 0 && !isKnownStable(kStabilityMargin * largest)) {
    search.most = kStabilityMargin * largest;
    largest = largestStable(search, isKnownStable);
  }
  return largest;
}

}  // namespace

double criticalStiffness_N_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const WallPresses presses(device, rate_Hz, stabilised);
  return critical(kStiffnessSearch, [&](double k) { return presses.allComeToRestOn({k, 0}); });
}

double criticalDamping_Ns_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised, double stiffest_N_per_m) {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  const WallPresses presses(device, rate_Hz, stabilised);
  constexpr double kSoft_N_per_m = 300;
  const double softest_N_per_m = std::min(kSoft_N_per_m, stiffest_N_per_m);
  constexpr StabilitySearch kDampingSearch{.least = 0.1, .most = 200, .climb = 1.5};
  return critical(kDampingSearch, [&](double b) {
    return presses.allComeToRestOn({softest_N_per_m, b}) && presses.allComeToRestOn({stiffest_N_per_m, b});
  });
}

double criticalTorsion_Nm_per_rad(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  if (!(device.rotation.maxTorque_Nm > 0)) return std::numeric_limits<double>::infinity();
  const double r = gyration_m(device);
  return r * r * criticalStiffness_N_per_m(rotationAsTranslation(device), rate_Hz, stabilised);
}

SurfaceLimits surfaceLimits(const DeviceInfo& device, double rate_Hz, bool stabilised) {
  const double stiffest_N_per_m = kStabilityMargin * criticalStiffness_N_per_m(device, rate_Hz, stabilised);
  return {stiffest_N_per_m, kStabilityMargin * criticalDamping_Ns_per_m(device, rate_Hz, stabilised, stiffest_N_per_m),
          kStabilityMargin * criticalTorsion_Nm_per_rad(device, rate_Hz, stabilised)};
}

}  // namespace haptics
