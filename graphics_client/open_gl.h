#pragma once

#include "common/error/error.h"

namespace haptics {

/// Why the X display, which answers, cannot be drawn on: VTK would end the process there.
[[nodiscard]] Result<void> checkOpenGl();

}  // namespace haptics
