#pragma once

#include <string>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// What Assimp builds wrongly, or reads beyond its numbers for: Cone, Cylinder, Disk2D, ElevationGrid, Extrusion.
[[nodiscard]] bool isMadeOfFaces(std::string_view element);

/// The shape as the attributes and the content of an IndexedFaceSet: ` coordIndex="..."><Coordinate point="..."/>`. Refused, naming
/// the field: a length that is none, fewer heights than the grid has, lists whose numbers do not come out even.
/// Source: ISO/IEC 19775-1 (X3D 3.3), 13.3 (Cone, Cylinder, ElevationGrid, Extrusion) and 14.3 (Disk2D).
/// @param attributes  The element's XmlTag::inside.
[[nodiscard]] Result<std::string> facesOfX3dShape(std::string_view element, std::string_view attributes);

}  // namespace haptics
