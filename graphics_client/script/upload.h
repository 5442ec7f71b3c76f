#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "graphics_client/script/connection.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// Reads the local files that the transaction's meshes (with the unit or extent given there), images and so on name,
/// uploads them with progress on standard error, and names them by their hash instead. Errors name the file or the upload:
/// import refused, name not used, server refused, connection lost. Ctrl-C cancels the upload under way.
[[nodiscard]] Result<void> uploadFiles(Connection& connection,
                                       const std::map<std::string, std::filesystem::path>& files,
                                       v1::Transaction& transaction);

/// The same with what lies beside the scene file (takeFilesBeside()). What the present scene names is not sent.
[[nodiscard]] Result<void> uploadBeside(Connection& connection, const std::filesystem::path& scene,
                                        v1::Transaction& transaction, const SceneVersion& present);

}  // namespace haptics
