#pragma once

#include <cstdint>
#include <string>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// An FBX, of which Assimp shows what the file shows.
struct FbxFile {
  std::string file;
  std::uint64_t skipped = 0;  ///< Places of NURBS, patches and curves, and meshes that are not as they should be.
  std::string fault = {};     ///< Why the first of those is not; empty: there is none.
  LeftOut leftOut;            ///< Places of meshes that the scene does not show.
};

/// Takes a geometry from the models that are hidden: by `Show`, by `Visibility`, which those below have too unless `Visibility
/// Inheritance` is 0, or by a display layer. Counts those, the meshes that no model of the scene has, and what is no mesh.
/// Refused, naming version, geometry and field: a text that is cut off; a version before 7.1 (2011), which Assimp does not read; a
/// list of polygons whose last does not end; a model that does not inherit its parents' scales as a product of transforms has them.
[[nodiscard]] Result<FbxFile> preparedFbx(std::string file);

}  // namespace haptics
