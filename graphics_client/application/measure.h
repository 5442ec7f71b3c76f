#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/maths/vec.h"

namespace haptics {

/// Places that are measured at once: two for a distance, a third for the angle at the second.
inline constexpr std::size_t kMaxMeasured = 3;

/// What lies between places, world frame, in words: millimetres and degrees. With fewer than two, what to do.
/// @param pointer  On the surface under it, whose coordinates are said; nothing: it is on none.
[[nodiscard]] std::string measureText(std::span<const Vec3> places, const std::optional<Vec3>& pointer);

}  // namespace haptics
