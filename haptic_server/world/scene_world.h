#pragma once

#include <string>
#include <vector>

#include "world.h"

namespace haptics {

/// A scene as the server has it, for a program that has a loop and a device of its own: all that a scene file says is
/// felt, textures, maps of friction and stiffness, bodies that move and bodies that yield. The same scene and positions
/// give the server's forces, bit for bit. One thread at a time.
///
/// step() and run() belong into the loop as World's do. Everything else may take milliseconds, a large mesh or a field that
/// grows seconds. Files are read by the programs asset_importer, inventor_importer and assimp_importer, each in a process of its own; they
/// are looked for in the folder that the environment variable HAPTICS_PROGRAMS names, beside the running program, and where
/// they were installed.
class SceneWorld {
 public:
  /// A body of the scene.
  struct Body {
    std::uint64_t number = 0;  ///< As in World::Sample::body.
    std::string name;
    World::Pose pose;  ///< Where it is now.
  };

  /// An empty scene.
  /// @param folders  Below which an edit may name files of meshes and images; the first that holds one counts.
  /// @throws InvalidInput a value of the device out of range.
  explicit SceneWorld(const World::Device& device, std::vector<std::string> folders = {});
  ~SceneWorld();
  SceneWorld(SceneWorld&&) noexcept;
  SceneWorld& operator=(SceneWorld&&) noexcept;

  /// The scene of a file, whose folder comes before the others.
  /// @throws InvalidInput as apply(); a file that cannot be read.
  [[nodiscard]] static SceneWorld load(const std::string& file, const World::Device& device,
                                       std::vector<std::string> folders = {});

  /// One edit, all of it or none, in the text of scene files: `operations { set_pose { ... } }`. Felt from the next step on,
  /// without a step of the force.
  /// @return What reading and making its meshes and images kept and dropped, and warnings: a line each.
  /// @throws InvalidInput what is wrong with which field, where in the text, and what would be right.
  std::vector<std::string> apply(const std::string& edit);
  [[nodiscard]] std::vector<Body> bodies() const;  ///< In order of number.
  /// SHA-256 over all objects and their meshes, in hexadecimal digits: a server's with the same scene is the same.
  [[nodiscard]] std::string root() const;
  /// Makes the dents that stay in plastic bodies part of their shapes, as the server does every 0.2 s. Until then 6 are
  /// held, and further ones do not stay.
  void keepDents();

  /// As World's.
  World::Sample step(const World::Vector& hip_m) noexcept;
  World::Sample step(const World::Vector& hip_m, std::uint64_t missedTicks) noexcept;
  void run(std::span<const World::Vector> hips_m, std::span<World::Sample> samples) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptics
