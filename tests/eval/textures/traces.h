#pragma once

#include <cstdint>
#include <utility>
#include <vector>

// Curves for the contact sheet.
namespace haptics::eval {

using Trace = std::vector<std::pair<double, double>>;

/// Friction force along the way over the pressing force, by the place in mm.
struct FrictionTraces {
  Trace toAndFro;
  Trace periodic;
  Trace fine, coarse;  ///< Sandpaper.
};
[[nodiscard]] FrictionTraces traceFriction(std::uint32_t seed);

/// Angle (degrees) that the force has turned by, less what the exact sphere's has, by the place in mm.
struct ShadingTraces {
  Trace unshaded, shaded;
};
[[nodiscard]] ShadingTraces traceShading();

}  // namespace haptics::eval
