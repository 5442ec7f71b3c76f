#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/error/error.h"

// OpenMesh's readers believe their input. Measured with 9.0: a PLY header that does not end loops for ever; a claimed
// face of 4 thousand million corners, or a claimed 300 million vertices, is allocated; binary PLY coordinates of type
// double become 0; an OBJ vertex "nan" is skipped, which shifts all that follow; "mtllib" opens any file named; an STL
// with a wrong count loads empty; a malformed OM aborts the process by assert. So no file reaches them as it is: each
// is checked and rewritten here as the plainest file of its own format, which holds geometry alone and which they read
// right.
namespace haptics {

/// A file that OpenMesh reads as it is meant, and what it must find in it.
struct PlainFile {
  std::string bytes;
  bool binary = false;
  std::uint64_t vertices = 0;            ///< In the original file.
  std::uint64_t polygons = 0;            ///< In `bytes`.
  std::uint64_t triangles = 0;           ///< Of those polygons once they are cut; not known of OM files.
  std::uint64_t degenerate = 0;          ///< Faces of fewer than three corners, left out of `bytes`.
  std::uint64_t outOfRange = 0;          ///< Triangles left out because their polygon names a vertex that is not there.
  std::uint64_t headerLinesSkipped = 0;  ///< Of a PLY file: they begin with no keyword of PLY.
  std::uint64_t bytesAtEnd = 0;          ///< Of a binary STL file, after its last triangle; left out.
  bool readerDropsDegenerate = false;  ///< OpenMesh's reader leaves out faces with fewer than three different corners.
};

[[nodiscard]] Result<PlainFile> plainObj(std::string_view file);
[[nodiscard]] Result<PlainFile> plainOff(std::string_view file);
[[nodiscard]] Result<PlainFile> plainPly(std::string_view file);
[[nodiscard]] Result<PlainFile> plainStl(std::string_view file);
[[nodiscard]] Result<PlainFile> plainOm(std::string_view file);

}  // namespace haptics
