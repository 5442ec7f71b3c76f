#pragma once

#include <cstddef>
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
      0;  ///< Shapes and nodes that nobody reads: texts, NURBS, lines, points, prototypes, other files, nodes of no standard.
  std::uint64_t unshown = 0;  ///< Shapes that a Switch, an LOD or visible="false" hides.
};

/// Puts a copy of a group, Transform or Switch where it is used again: Assimp shows it at the first place alone. Refused: copies
/// that make many times the file's bytes.
/// @param file  As plainXml() makes it.
[[nodiscard]] Result<std::string> withGroupsInPlace(std::string file);

/// Names the groups that Assimp leaves out with all that is in them (Collision, Anchor, CADPart, HAnimJoint and so on), and
/// StaticGroup, in which it finds no name of outside, by those that it knows, and lines, which it takes for faces, points. Hides
/// what a Switch or LOD does not show, of which it counts some children only, and puts a Shape into groups of nothing, which it
/// leaves twice. Makes faces of the shapes that it builds wrongly (facesOfX3dShape()), axes of rotations 1 long, gives strips
/// indices, turns faces and triangles of ccw="false", at which it does not look, and leaves faces without corners out. What
/// cannot be felt and has to be right for it is left out: appearances, normals, colours, texture coordinates, metadata, proxies
/// of collisions. Refused, naming the field: GeoCoordinate in degrees or of a map; strips of fewer than three points, or of
/// more than the file can hold; indices and rotations that are none.
[[nodiscard]] Result<X3dText> preparedX3d(std::string_view file);

}  // namespace haptics
