#pragma once

#include <cstdint>
#include <vector>

#include "tests/eval/report.h"

namespace haptics::eval {

/// Force shading (section 4.1 of the paper) against exact shapes, shaded and unshaded in one run, and shapes with edges
/// that have to stay sharp.
[[nodiscard]] std::vector<Record> measureShading(std::uint64_t seed);

}  // namespace haptics::eval
