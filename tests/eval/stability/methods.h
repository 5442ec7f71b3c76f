#pragma once

#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "haptic_server/device/presets.h"
#include "haptic_server/servo/settling.h"
#include "tests/eval/stability/test_surface.h"

namespace haptics::eval {

/// What a method is told: it need not be so.
struct Rendering {
  const TestSurface* ground = nullptr;
  DevicePreset device;
  double period_s = 1e-3;
  double delay_s = 0;
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;  ///< Of the surface, along the penetration.
};

/// A way from the measured position to the force, in virtual time: what is to be felt is the same spring and damper.
using StabilityMethod = ForceRenderer;

struct MethodEntry {
  std::string_view name;   ///< As in the records.
  std::string_view title;  ///< For people,
  std::string_view note;   ///< and what it is.
  std::function<std::unique_ptr<StabilityMethod>(const Rendering&)> make;
};

inline constexpr std::string_view kOursMethod = "ours";

/// Those that are compared, ours last.
[[nodiscard]] const std::vector<MethodEntry>& stabilityMethods();
/// The production step with the server's stabiliser.
[[nodiscard]] std::unique_ptr<StabilityMethod> makeOurs(const Rendering& rendering);
/// A bare spring; its damper on the raw difference of positions.
[[nodiscard]] std::unique_ptr<StabilityMethod> makeBare(const Rendering& rendering);

}  // namespace haptics::eval
