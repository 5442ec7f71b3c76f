#pragma once

#include <filesystem>
#include <string_view>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Reads an Open Inventor file with Coin: every shape of the scene graph as triangles, in the coordinates of the file's
/// root, counter-clockwise seen from outside. Needs no display. Files that it includes are taken from `folder` and
/// below. Skipped and counted: includes from elsewhere, and NURBS shapes, for tessellating them wants OpenGL.
/// Thread-safe: one file at a time.
[[nodiscard]] Result<PolygonSoup> readInventor(std::string_view file, const std::filesystem::path& folder);

}  // namespace haptics
