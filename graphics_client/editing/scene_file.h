#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/error/error.h"
#include "graphics_client/editing/edit_history.h"
#include "graphics_client/editing/local_asset.h"
#include "graphics_client/mirror/mirror_view.h"

// Scene files that every server, World and client opens: what a generator makes is said by its generator; each other asset
// is named by a file of its canonical bytes that lies beside the scene file and is named after the first object that has
// it: "cup.mesh", ".field", ".values", ".points" or ".moved". Any thread; errors name the file.
namespace haptics {

/// The text of a scene (of its object `name` alone where that is not empty) for a file in the folder, into which its assets
/// are written. A file that is there is never replaced: where it holds something else, the next is "cup-2.mesh". Refused: an
/// asset of the scene is not here yet, a folder that cannot be written to.
/// @param folder  Nothing: assets are named by their hash, for a server that holds them.
[[nodiscard]] Result<std::string> sceneFor(const std::optional<std::filesystem::path>& folder, const MirrorView& view,
                                           const std::string& name = "");
/// Writes that into a file, whole or not at all, also in place of one that is there.
[[nodiscard]] Result<void> saveScene(const MirrorView& view, const std::filesystem::path& file);

/// Reads each file that the transaction names and that lies beside the scene file or below, and names it by its hash
/// instead. What is not there is left to the server's asset folders; likewise what is not below. Refused, by the field: a
/// file that cannot be read, and what `take` refuses.
/// @param take  Called with the name and the content.
[[nodiscard]] Result<void> takeFilesBeside(
    const std::filesystem::path& scene, v1::Transaction& transaction,
    const std::function<Result<void>(const std::string& name, LocalFile file)>& take);

/// An edit that removes the present objects and carries out the file's transaction, with uploads of what lies beside it and
/// the present scene does not name. Refused: as above.
[[nodiscard]] Result<Edit> openScene(const std::filesystem::path& file, const SceneVersion& present);

/// Operations that openScene() has put before those of the file.
[[nodiscard]] int removalsBefore(const Edit& opened);
/// What the server says of such an edit, with the numbers that the file's operations have in the file.
[[nodiscard]] Error asInFile(Error error, int removals);

}  // namespace haptics
