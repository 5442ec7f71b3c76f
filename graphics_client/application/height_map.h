#pragma once

#include <QString>
#include <memory>

#include "common/error/error.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// Pixels along a side of an image that is to be a height map.
inline constexpr int kMaxImageSide_px = 2048;

/// The brightness of a picture, 0 to 1, as a field that repeats; its first row becomes the highest. Any thread; takes up
/// to a second. Refused, without a field's name: no picture that Qt can read, sides beyond kMaxImageSide_px (told from
/// its head, before it is decoded), and what SampledField refuses.
[[nodiscard]] Result<std::shared_ptr<const SampledField>> readHeightMap(const QString& file);

}  // namespace haptics
