#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"
#include "haptic_server/step/servo_scene.h"

namespace haptics::eval {

/// An object of the user's scene.
struct LoadedObject {
  std::string name;
  Material material;
  Pose pose;
  std::shared_ptr<const TriMesh> mesh;
  std::shared_ptr<const CollisionMesh> surface;
  std::optional<ToolProperties> tool = std::nullopt;  ///< The hand holds it.
};

/// Reads a scene file as the server does. Errors name file and field.
[[nodiscard]] Result<std::vector<LoadedObject>> loadScene(const std::string& file,
                                                          std::vector<std::filesystem::path> assets);

/// The scene for the servo, object `i` with id i + 1.
[[nodiscard]] ServoScene servoSceneOf(const std::vector<LoadedObject>& objects);

}  // namespace haptics::eval
