#pragma once

#include <string_view>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

// What each format's file holds of geometry. Nothing that a file claims is believed beyond its length. Refused, saying where,
// when a file is cut off, damaged or no mesh. Vertices that no face names may be anything.
namespace haptics {

[[nodiscard]] Result<PolygonSoup> readObj(std::string_view file);
[[nodiscard]] Result<PolygonSoup> readOff(std::string_view file);
[[nodiscard]] Result<PolygonSoup> readPly(std::string_view file);
[[nodiscard]] Result<PolygonSoup> readStl(std::string_view file);
/// OpenMesh's own binary format.
[[nodiscard]] Result<PolygonSoup> readOm(std::string_view file);

}  // namespace haptics
