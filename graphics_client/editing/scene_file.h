#pragma once

#include <filesystem>
#include <vector>

#include "common/error/error.h"
#include "graphics_client/editing/edit_history.h"
#include "graphics_client/mirror/mirror_view.h"

// Scene files that a server can be given that holds none of their assets. Beside NAME.scene lie the assets that it
// names, each in a file of its canonical bytes that is named by their hash: "4f...e1.mesh", ".field", ".values",
// ".moved" or ".points". Scene files of one folder share them. Any thread; errors name the file.
namespace haptics {

/// Writes the file, if there is one instead of it, and its assets. Refused: an asset of the scene is not here yet.
[[nodiscard]] Result<void> saveScene(const MirrorView& view, const std::filesystem::path& file);

/// Writes these assets beside the file, as saveScene() does.
[[nodiscard]] Result<void> saveBeside(const std::filesystem::path& file, const std::vector<AssetContent>& assets);

/// An edit that removes the present objects and carries out the file's transaction, with uploads of the assets that the
/// present scene does not name. Refused: an asset is missing, damaged, or of another kind than its name says.
[[nodiscard]] Result<Edit> openScene(const std::filesystem::path& file, const SceneVersion& present);

/// The assets that the transaction of a scene file names, lie beside it, and are not named by the present scene. Refused:
/// one is damaged, or of another kind than its name says.
[[nodiscard]] Result<std::vector<AssetContent>> assetsBeside(const std::filesystem::path& file,
                                                             const v1::Transaction& transaction,
                                                             const SceneVersion& present);

}  // namespace haptics
