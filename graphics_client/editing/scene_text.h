#pragma once

#include <string>

#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// Adds an object with this content, of assets that are named by their hash.
[[nodiscard]] v1::AddObject additionOf(const ObjectRecord& record);

/// A scene as a file that `hapticctl apply` and `haptic_server --scene` take: one `add` for each object (only the named
/// one when `name` is not empty). Meshes are named by their hash, so a server takes it that holds them.
[[nodiscard]] std::string sceneText(const SceneVersion& scene, const std::string& name);
/// The same with objects that are driven where they are.
[[nodiscard]] std::string sceneText(const MirrorView& view, const std::string& name);

}  // namespace haptics
