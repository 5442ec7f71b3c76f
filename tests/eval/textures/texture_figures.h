#pragma once

#include <cstdint>
#include <vector>

#include "tests/eval/report.h"
#include "tests/eval/textures/strokes.h"
#include "tests/eval/textures/texture_cases.h"

namespace haptics::eval {

/// What an exhibit came to with positions given.
struct TextureFigures {
  Record record;
  StrokeSignals stroke;
};

/// Smoothness of the field, spectra of height and force, work, lateral stiffness, false force.
[[nodiscard]] TextureFigures measureTexture(const TextureCase& textureCase, std::uint64_t seed);
/// Smoothness alone, of a field wrapped round an intermediate surface.
[[nodiscard]] Record measureWrapped(const TextureCase& textureCase, std::uint64_t seed);

/// Eq. (4) as printed against values computed by hand, and the work of a loop by either law, literal or shifted.
[[nodiscard]] std::vector<Record> measureLaws(std::uint64_t seed);

/// Of the grating and bump mapping too: K of Eq. (4) in all figures, between the paper's 1 and 2.
inline constexpr double kGain = 1.5;

}  // namespace haptics::eval
