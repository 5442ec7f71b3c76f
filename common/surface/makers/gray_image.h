#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// Brightness, 0 to 1, the first row on top.
struct GrayImage {
  std::uint32_t width = 0, height = 0;
  std::vector<float> pixels;
};

// Each refuses what its library cannot read to the end, and sides that no SampledField may have.
[[nodiscard]] Result<GrayImage> readPng(std::string_view bytes);
[[nodiscard]] Result<GrayImage> readJpeg(std::string_view bytes);

}  // namespace haptics
