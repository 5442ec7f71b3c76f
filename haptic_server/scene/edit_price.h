#pragma once

#include <cstddef>
#include <vector>

#include "common/error/error.h"
#include "common/importer/mesh_recipe.h"
#include "common/scene/scene.h"
#include "haptic_server/scene/asset_store.h"

// What work takes, by its numbers, before it begins. Times are those of a slow or busy processor, some three times what a usual one
// takes; `haptic_eval fuzz prices` compares both.
namespace haptics {

/// Meant as at most; some edits take more (tests/README.md).
struct Price {
  double time_s = 0;         ///< Of one processor: all threads and importer processes together.
  double kept_bytes = 0;     ///< Of what is made, until the edit is decided.
  double working_bytes = 0;  ///< Beside that, while one of it is made.

  [[nodiscard]] double memory_bytes() const noexcept { return kept_bytes + working_bytes; }
  /// One after the other.
  Price& operator+=(const Price& next) noexcept;
};

/// Of one edit: the largest sphere with a mass. Larger keeps a worker from others for longer, and takes more memory.
inline constexpr double kMaxTime_s = 40, kMaxMemory_bytes = 2e9;
/// Refused, with the price: more.
[[nodiscard]] Result<void> checkPrice(const Price& price);

/// What prices go by.
struct MeshNumbers {
  double triangles = 0, vertices = 0;
  double longest_m = 0;        ///< Side of its box,
  Vec3 centre_m{0};            ///< and its middle.
  double longTriangles = 0;    ///< In whose boxes many others are.
  bool closed = true;          ///< It has an inside,
  bool closedAndPlain = true;  ///< and does not pass through itself.
};
[[nodiscard]] MeshNumbers numbersOf(const MeshAsset& mesh);
[[nodiscard]] MeshNumbers numbersOf(const MeshRecipe& recipe) noexcept;
[[nodiscard]] double areaOf_m2(const MeshRecipe& recipe) noexcept;

/// To generate a mesh, and to build what is felt of it.
[[nodiscard]] Price priceOfMesh(const MeshNumbers& mesh) noexcept;
/// simplify().
[[nodiscard]] Price priceOfSimplifying(const MeshNumbers& mesh, double stiffness_N_per_m) noexcept;
/// To compute a field; that of a file, whose import has limits of its own, is none.
[[nodiscard]] Price priceOf(const FieldSource& source) noexcept;
/// grownReactionDiffusion().
[[nodiscard]] Price priceOfGrowing(const GrownReactionDiffusionSource& source, const MeshNumbers& mesh,
                                   double area_m2) noexcept;
/// A mesh as its lattice and a residue have it.
[[nodiscard]] Price priceOfShape(const MeshNumbers& mesh, const DeformationProperties& deformation);
/// What is looked at of all of a mesh for a motion.
[[nodiscard]] Price priceOfBody(const MeshNumbers& mesh, const MotionProperties& motion) noexcept;
/// makeToolShell().
[[nodiscard]] Price priceOfTool(const MeshNumbers& mesh, double area_m2, double spacing_m) noexcept;
/// Its normals, with so many lines that are sharp.
[[nodiscard]] Price priceOfShading(const MeshNumbers& mesh, std::size_t creases) noexcept;
/// Its box and its warnings.
[[nodiscard]] Price priceOfLooking(const MeshNumbers& mesh) noexcept;
/// Its sharp points, for a tool.
[[nodiscard]] Price priceOfSharpPoints(const MeshNumbers& mesh) noexcept;
/// To look for the steepest place of a texture.
[[nodiscard]] Price priceOf(const Texture& texture) noexcept;
/// To convert the models of recorded textures to the servo's rate.
[[nodiscard]] Price priceOf(const std::vector<Effect>& effects) noexcept;
/// Of any edit with so many operations, in a scene of so many objects.
[[nodiscard]] Price priceOfDeciding(std::size_t operations, std::size_t objects) noexcept;

}  // namespace haptics
