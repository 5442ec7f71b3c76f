#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "tests/eval/report.h"
#include "tests/eval/textures/texture_cases.h"

namespace haptics::eval {

/// Every exhibit under every device preset at 1, 4 and 10 kHz, with no hand and the light hand: by the production step,
/// with K as it was set, and by bump mapping, which has no K; the plain surface beside them. All with the stabiliser, as
/// the server has it.
[[nodiscard]] std::vector<Record> measureResting(const std::vector<TextureCase>& textureCases);

/// Gratings of several heights and wavelengths at 1 kHz, struck as a hand that lets go does and up to as a slow stroke that
/// stops does: the worst. Within all of these the light hand's device has to rest.
inline constexpr std::array kMapHeights_m{0.1e-3, 0.2e-3, 0.5e-3, 1e-3, 2e-3};
inline constexpr std::array kMapWavelengths_m{0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3};
[[nodiscard]] std::vector<Record> mapGratings();

inline constexpr std::string_view kUnclamped = "ours_without_gain_clamp";
inline constexpr std::string_view kBumpMapping = "bump_mapping";

}  // namespace haptics::eval
