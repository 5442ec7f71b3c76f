#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {

/// How many of them pull from both sides wherever the hand is: they may fight each other.
[[nodiscard]] std::size_t pullingEverywhere(const std::vector<Effect>& effects) noexcept;

/// An object's effects as they are felt: each with no more stiffness and damping than the device bears of a surface (less where no
/// observer looks ahead and it pulls from both sides; those of a scene that do so wherever the hand is, together), and those in the frame
/// of a body that moves together with no more than it bears (stableStiffnessShare()). The force of a recorded texture grows by no more for
/// each m/s of the hand than that damping.
/// @param together  pullingEverywhere() of all objects of the scene.
/// @param apparentMass_kg  Of that body; none: it stands still.
[[nodiscard]] std::vector<Effect> stableEffects(std::vector<Effect> effects, std::size_t together,
                                                std::optional<double> apparentMass_kg, const DeviceLimits& device);

/// What an effect pushes with at most, N; infinite where only the device's limit bounds it.
[[nodiscard]] double strongest_N(const Effect& effect) noexcept;
/// A smaller force is not noticed, by what `advise` and Simplify count as noticed.
inline constexpr double kNoticed_N = 0.05;

/// A warning of each that is felt as another one than asked for, or not noticed, and of a vibration from half the servo's rate on.
/// @param together  pullingEverywhere() of all objects of the scene.
[[nodiscard]] std::vector<std::string> effectWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                      std::size_t together, const DeviceLimits& device);

}  // namespace haptics
