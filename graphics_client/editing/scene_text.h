#pragma once

#include <string>

#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// Adds an object with this content, of assets that are named by their hash.
[[nodiscard]] v1::AddObject additionOf(const ObjectRecord& record);

/// A scene as an edit: one `add` for each object (only the named one when `name` is not empty). Assets are named by their
/// hash, so a server takes it that holds them; saveScene() writes what every server takes.
[[nodiscard]] std::string sceneText(const SceneVersion& scene, const std::string& name);
/// The same with objects that are driven where they are.
[[nodiscard]] v1::Transaction additionsOf(const MirrorView& view, const std::string& name);
[[nodiscard]] std::string textOf(const v1::Transaction& transaction);

}  // namespace haptics
