#pragma once

#include <cstdint>
#include <span>

#include "common/surface/sampled_field.h"

namespace haptics {

/// Computed values with their mean taken away, scaled so that the largest becomes 1 or -1. \param values side * side.
[[nodiscard]] SampledField zeroMeanField(std::uint32_t side, std::span<const double> values);

}  // namespace haptics
