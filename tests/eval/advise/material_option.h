#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/device/presets.h"
#include "haptic_server/simplification/force_difference.h"
#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// Servo rates that are weighed, rising. The highest is what the others are compared with.
inline constexpr std::array kRates_Hz{60.0, 125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 10'000.0};

/// A material at one rate: the force of the production step on the advised meshes, held from tick to tick, from that of
/// the own material on them at the highest rate. The half a period by which it comes later is no error of it: two events are felt
/// as one up to 45 ms apart (Vogels 2004).
struct Trial {
  ForceDifference tap;               ///< Where the hand comes down on it and where it lifts off, at 0.1 m/s.
  ForceDifference stroke;            ///< Along it, at 0.1 m/s.
  bool steady = true;                ///< A device comes to rest on it, with no hand and with a light one.
  double worstCycle_um = 0;          ///< Limit cycle.
  std::vector<std::string> happens;  ///< Hand, and what it meets instead of rest.

  [[nodiscard]] double epsilon_p99() const noexcept { return std::max(tap.epsilon_p99, stroke.epsilon_p99); }
  /// Contact that begins later at a lower rate is an error of its force, and no missed contact.
  [[nodiscard]] bool sameFeel() const noexcept { return epsilon_p99() < 1 && stroke.wrongSideTicks == 0; }
  [[nodiscard]] bool good() const noexcept { return sameFeel() && steady; }
};

/// A material that one object could have. Stiffness and damping are all that a scene can choose of the contact: its
/// corrections cannot be switched off.
struct MaterialOption {
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  bool own = false;  ///< The scene's.
  std::array<Trial, kRates_Hz.size()> trials;

  /// How deep 1 N presses.
  [[nodiscard]] double depth_mm() const noexcept { return 1e3 / stiffness_N_per_m; }
  /// Index of the lowest rate at which a device comes to rest on it; none when there is none.
  [[nodiscard]] std::optional<std::size_t> steadyFrom() const noexcept;
  /// At the highest rate, where nothing of the difference is the rate's.
  [[nodiscard]] const Trial& atBest() const noexcept { return trials.back(); }
};

/// Half, all and twice the object's stiffness; no damping, half of its own, its own and twice as much (of a scene's
/// default where it has none). By stiffness, then damping.
/// @param scene  With the advised meshes.
/// @param object  Index of the object whose material varies.
/// @param strokes  Over it; not empty.
[[nodiscard]] std::vector<MaterialOption> optionsFor(const std::vector<LoadedObject>& scene, std::size_t object,
                                                     const std::vector<HandStroke>& strokes,
                                                     const DevicePreset& device);

}  // namespace haptics::eval
