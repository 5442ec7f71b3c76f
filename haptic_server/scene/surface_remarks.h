#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/object_assets.h"

namespace haptics {

/// Warnings of a texture or friction whose finest detail is finer than two steps of the device's encoder, which feel it
/// as something else (0: the step is not known), or than two edges of the mesh, which show it so.
[[nodiscard]] std::vector<std::string> surfaceRemarks(const ObjectRecord& record, const ObjectAssets& assets,
                                                      double encoderStep_m);

}  // namespace haptics
