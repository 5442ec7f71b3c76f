#pragma once

#include <filesystem>
#include <vector>

#include "tests/eval/advise/advice.h"

namespace haptics::eval {

/// Throws std::runtime_error where writeAdvised() would find no scene file to read, or one that it would replace.
void checkApply(const std::filesystem::path& scene, const std::filesystem::path& folder);

/// Writes the advised scene into a folder, which is made: the scene's text but for the meshes that are replaced, each in a
/// file beside it (PLY, metres), and the spacing of a tool's points, with an operation more for each object whose own
/// stiffness and damping are not steady; and every file that the text names still, so that the scene runs by itself. Throws
/// std::runtime_error naming the file or field that is in the way; nothing is replaced.
/// @return The written scene, read again.
std::vector<LoadedObject> writeAdvised(const SceneAdvice& advice, const std::filesystem::path& scene,
                                       const std::vector<std::filesystem::path>& assets,
                                       const std::filesystem::path& folder);

}  // namespace haptics::eval
