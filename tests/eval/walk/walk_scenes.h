#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "tests/eval/random.h"
#include "tests/eval/walk/triangle_soup.h"

namespace haptics::eval {

/// One scene of the walk: what the method gets and what the judges get of it.
struct WalkScene {
  std::string name;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces;
  std::vector<Pose> poses;  ///< In the world.
  TriangleSoup soup;

  void add(const std::vector<Vec3f>& vertices, const std::vector<TriangleIndices>& triangles, const Pose& pose);
};

/// A scene that is made when its turn has come.
struct WalkSceneSource {
  std::string name;
  std::filesystem::path file;  ///< Of a model; empty when the scene is generated.
  std::uint64_t number = 0;    ///< Among all scenes.
  /// Of bodies that move, or of meshes that pass through themselves: the reference has no part in it, what is inside is
  /// judged by winding number.
  bool winding = false;
};

/// Those of the shapes that are generated, the models and those judged by winding number, which makeWalkScene() does not
/// make; or only the one that is named. A model is looked for in the folder that deploy/models/fetch_and_report fills, or
/// where it is installed; one that is not there is left out, unless `models` or `only` ask for it. Throws
/// std::invalid_argument where none is called `only`, std::runtime_error where a file that is asked for is missing.
[[nodiscard]] std::vector<WalkSceneSource> chosenWalkScenes(const std::filesystem::path& models,
                                                            const std::string& only);

/// In a random orientation. Throws std::runtime_error with the reason when a model cannot be read.
/// @param closed  A model's holes are closed by fans about their middles: it has an inside then.
[[nodiscard]] WalkScene makeWalkScene(const WalkSceneSource& source, Random& random, bool closed = false);

}  // namespace haptics::eval
