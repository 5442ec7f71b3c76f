#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "common/scene/surface_properties.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// A texture to choose from, in its usual size.
struct TextureFamily {
  const char* name;
  const char* tip;
  const char* field;  ///< A v1::ScalarField in text format.

  [[nodiscard]] v1::ScalarField make() const;
};

[[nodiscard]] std::span<const TextureFamily> textureFamilies();

/// Number in textureFamilies(). Nothing: of what a mapped or grown pattern was made, or what layers it has, a record does
/// not tell.
[[nodiscard]] std::optional<std::size_t> textureFamilyOf(const FieldFamily& family);

/// Length of its waves, cells, grains or tiles, of layers the largest (metres). Nothing: a grown pattern, also as a
/// layer, has the size that it was grown with.
[[nodiscard]] std::optional<double> textureSize_m(const FieldFamily& family);
/// Scales all of its lengths. The family has a size.
void setTextureSize_m(FieldFamily& family, double size_m);

/// A sampled field in tiles, mapped from a box around the object, which fits any shape.
[[nodiscard]] v1::ScalarField imageField(const ContentHash& field);

/// What an edit leaves of the object's texture as it is, to be changed; of one that has none the usual amplitude.
[[nodiscard]] v1::Texture textureOf(const SurfaceProperties& surface);

}  // namespace haptics
