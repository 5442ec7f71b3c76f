#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/object_assets.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {

/// A warning of a body that is so light that its surface is felt softer than asked for: stableStiffnessShare().
[[nodiscard]] std::vector<std::string> motionWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                                      const DeviceLimits& device);

}  // namespace haptics
