#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// An X3D file's text as Assimp reads it whole.
struct X3dText {
  std::string text;
  std::string unit;  ///< Metres, where it says so.
  std::uint64_t skipped =
      0;  ///< Shapes and nodes that nobody reads: texts, NURBS, lines, points, prototypes, other files.
};

/// Names the groups that Assimp leaves out with all that is in them (Collision, Anchor, LOD, CADPart, HAnimJoint and so on) by
/// those that it knows, lines, which it takes for faces, points, and turns faces of ccw="false", which it does not look at.
/// Normals, colours and texture coordinates, which cannot be felt and have to be right for it, are left out.
/// Refused: that of shapes other than faces and triangles by index.
[[nodiscard]] Result<X3dText> preparedX3d(std::string_view file);

}  // namespace haptics
