#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "graphics_client/script/connection.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// Reads the local files whose names the transaction's meshes (with the unit or extent given there) and images carry, uploads
/// them with progress on standard error, and names them by their hash instead. Errors name the file or the upload:
/// import refused, name not used, server refused, connection lost. Ctrl-C cancels the upload under way.
[[nodiscard]] Result<void> uploadFiles(Connection& connection,
                                       const std::map<std::string, std::filesystem::path>& files,
                                       v1::Transaction& transaction);

/// Uploads the assets that lie beside a scene file (editing/scene_file.h) and that the present scene does not name.
[[nodiscard]] Result<void> uploadBeside(Connection& connection, const std::filesystem::path& scene,
                                        const v1::Transaction& transaction, const SceneVersion& present);

}  // namespace haptics
