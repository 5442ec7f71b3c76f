#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"

namespace haptics {

struct InventorTriangles {
  std::vector<Vec3f> corners;  ///< Three a triangle, in the coordinates of the file's root, units of the file.
  std::uint64_t skipped = 0;   ///< NURBS shapes, and included files that are not in the folder.
};

/// Walks an Open Inventor scene graph with Coin and takes every shape as triangles, counter-clockwise seen from
/// outside. NURBS shapes are skipped, for tessellating them wants OpenGL. Files that it includes are taken from
/// `folder` and below. Needs no display. Not for use in a server: Coin crashes on many damaged files; see
/// readInventor().
[[nodiscard]] Result<InventorTriangles> gatherInventor(std::string_view file, const std::filesystem::path& folder);

}  // namespace haptics
