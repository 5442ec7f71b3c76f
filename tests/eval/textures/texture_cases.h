#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/surface_properties.h"
#include "common/surface/sampled_field.h"
#include "common/surface/scalar_field.h"
#include "tests/eval/textures/reference_field.h"

namespace haptics::eval {

/// A texture that is evaluated.
struct TextureCase {
  std::string name;   ///< As in the records.
  std::string title;  ///< For people.
  FieldFamily family;
  std::shared_ptr<const SampledField> sampled;  ///< Of a mapped family, else null.
  std::shared_ptr<const ScalarField> field;
  Reference reference;
  /// Along x: that of the strongest wave; 0 where a family sets none.
  double wavelength_m = 0;
};

/// Valleys to crests of every exhibit, unless a run says otherwise.
inline constexpr double kReliefHeight_m = 0.5e-3;

/// Of the exhibits that are computed: cells of 3 mm, spots so much longer than wide.
inline constexpr std::uint32_t kExhibitCells = 8;
inline constexpr double kExhibitElongation = 2;

/// Of a family that needs no sampled field.
[[nodiscard]] std::shared_ptr<const ScalarField> makeFieldOf(const FieldFamily& family);

/// One of every family, the mapped ones on a plane.
[[nodiscard]] std::vector<TextureCase> makeTextureCases(std::uint32_t seed);
/// The mapped ones of those again, round a cube, a cylinder and a sphere.
[[nodiscard]] std::vector<TextureCase> wrapped(const std::vector<TextureCase>& textureCases);

/// A grating across x: one wave of a Fourier series.
[[nodiscard]] TextureCase makeGrating(double wavelength_m);

/// The exhibit as a texture of this height, lowest to highest, with K of Eq. (4).
[[nodiscard]] Texture textureOf(const TextureCase& textureCase, double height_m, double gain_K);

}  // namespace haptics::eval
