#pragma once

#include <string>

#include "common/scene/scene.h"

namespace haptics {

/// A scene as a file that `hapticctl apply` and `haptic_server --scene` take: one `add` for each object (only the named
/// one when `name` is not empty). Meshes are named by their hash, so a server takes it that holds them.
[[nodiscard]] std::string sceneText(const SceneVersion& scene, const std::string& name);

}  // namespace haptics
