#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics::eval {

/// An object of the user's scene.
struct LoadedObject {
  std::string name;
  Material material;
  Pose pose;
  std::shared_ptr<const TriMesh> mesh;
  std::shared_ptr<const CollisionMesh> surface;
  std::optional<MotionProperties> motion = std::nullopt;
  DeformationProperties deformation = {};
  std::shared_ptr<const SurfaceDetail> detail = nullptr;  ///< As it is felt beyond its shape; null for nothing.
  std::vector<Effect> effects = {};

  [[nodiscard]] bool held() const noexcept { return motion && motion->tool; }  ///< By the hand, as a tool.
};

/// Reads a scene file as the server does. Errors name file and field.
[[nodiscard]] Result<std::vector<LoadedObject>> loadScene(const std::string& file,
                                                          std::vector<std::filesystem::path> assets);

/// Force shading of a surface as the material has it, but for creases that are named by vertices; null for none.
[[nodiscard]] std::shared_ptr<const SurfaceDetail> shadingOf(const Material& material, const CollisionMesh& surface);

/// The scene for the servo, object `i` with id i + 1. Rigid, and at rest.
[[nodiscard]] ServoScene servoSceneOf(const std::vector<LoadedObject>& objects);

}  // namespace haptics::eval
