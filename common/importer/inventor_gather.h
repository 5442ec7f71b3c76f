#pragma once

#include <string_view>

#include "common/error/error.h"
#include "common/importer/include_reader.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Loads Coin, which opens files of its own. Once, before gatherInventor().
void startInventor();

/// Walks an Open Inventor or VRML scene graph with Coin, and takes every shape as
/// triangles, counter-clockwise seen from outside, in the coordinates of the file's root. A face of fewer than three corners
/// is left out and counted; so are NURBS, whose tessellation wants OpenGL, flat texts, lines, points, nodes that Coin does not
/// know and files that are not to be had. Refused: a shape that names points that are not there; few bytes that repeat
/// themselves to very many triangles or nodes. Opens no file: from now on fopen() and stat() give this whole program what
/// `readIncluded` does, or nothing. Needs no display. Not for use in a server: Coin may crash on a damaged file and keeps
/// global state; see importer.h.
[[nodiscard]] Result<PolygonSoup> gatherInventor(std::string_view bytes, const IncludeReader& readIncluded);

}  // namespace haptics
