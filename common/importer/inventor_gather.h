#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// The bytes of a file that a file includes, by the name that it has there; nothing where it is to be left out.
using IncludeReader = std::function<std::optional<std::string>(const std::string& name)>;

/// Loads Coin, which opens files of its own. Once, before gatherInventor().
void startInventor();

/// Walks an Open Inventor scene graph with Coin and takes every shape as triangles, counter-clockwise seen from
/// outside, in the coordinates of the file's root. NURBS shapes, whose tessellation wants OpenGL, and files that are not
/// to be had are skipped and counted. Opens no file: from now on fopen() and stat() give this whole program what `readIncluded`
/// does, or nothing. Needs no display. Not for use in a server: Coin crashes on about one damaged file in a hundred (it does
/// not check what a shape's indices name), recurses as deep as the file nests and keeps global state; see importer.h.
[[nodiscard]] Result<PolygonSoup> gatherInventor(std::string_view file, const IncludeReader& readIncluded);

}  // namespace haptics
