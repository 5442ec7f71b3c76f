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
  std::uint64_t unshown = 0;  ///< Shapes that a Switch, an LOD or visible="false" hides.
};

/// Names the groups that Assimp leaves out with all that is in them (Collision, Anchor, LOD, CADPart, HAnimJoint and so on) by
/// those that it knows, and lines, which it takes for faces, points. Makes faces of a Cone or Cylinder and turns the sides of an Extrusion,
/// which it builds wrongly, gives strips indices, and turns faces and triangles of ccw="false", at which it does not look. What
/// cannot be felt and has to be right for it is left out: appearances, normals, colours, texture coordinates, metadata.
/// Refused: GeoCoordinate in degrees or of a map; more points in strips than the file can hold.
[[nodiscard]] Result<X3dText> preparedX3d(std::string_view file);

}  // namespace haptics
