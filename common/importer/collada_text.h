#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// A COLLADA file's text as Assimp reads it rightly.
struct ColladaText {
  std::string text;
  std::string unit;  ///< Metres, where it says so.
  std::uint64_t skipped =
      0;  ///< Places of meshes or nodes of other files, or that are not there, and of splines and other shapes.
  LeftOut leftOut;  ///< Skins, morphs, and meshes of scenes that are not shown.
};

/// Takes unit, and of a mesh all but its points and the faces' corners, out of what Assimp reads, which does not look whether
/// numbers are there; makes axes of rotations 1 long, and names coordinates. Puts the mesh of a skin or morph in its place, a
/// matrix in that of a skew, at which Assimp ends, triangles in that of fans, which it takes for polygons, and one outline in
/// that of a polygon with holes. What cannot be felt and has to be right for it is left out: materials, pictures, lights,
/// cameras, physics. Refused, naming the element: primitives without a count, which it leaves out, or with a vertex that
/// accessor and array do not have; a skew or rotation that is none; fans that make many times the file's bytes; holes that
/// take too long.
/// @param file  As plainXml() makes it.
[[nodiscard]] Result<ColladaText> preparedCollada(std::string_view file);

}  // namespace haptics
