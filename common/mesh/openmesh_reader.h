#pragma once

#include <string>

#include "common/error/error.h"
#include "common/mesh/plain_file.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Reads a checked file with OpenMesh into a soup, past its half-edge mesh: that tears off faces at non-manifold edges
/// and drops others silently. Refused when OpenMesh finds other counts than the check did. `format` is one of obj, ply,
/// stl, off and om. Thread-safe: readers are global objects with state, so one file is read at a time.
[[nodiscard]] Result<PolygonSoup> readWithOpenMesh(PlainFile plain, const std::string& format);

}  // namespace haptics
