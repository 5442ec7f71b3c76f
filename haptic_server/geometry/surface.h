#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "common/maths/vec.h"

// Interface sketch: the geometry room completes it.
namespace haptics {

class Surface;
[[nodiscard]] std::shared_ptr<const Surface> buildSurface(std::span<const Vec3f> vertices,
                                                          std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace haptics
