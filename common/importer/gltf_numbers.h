#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// Triangles that the default scene's meshes have, each counted once; none where that is not said (Draco).
using GltfTriangles = std::optional<std::uint64_t>;

/// Looks at what a glTF 2.0 file (JSON, or binary) claims, before anything believes it. Refused: no JSON, another version's
/// binary, an extension that is required and moves the geometry, positions that are not float32, more values than the file
/// has bytes for. What else is wrong is left to the reader.
/// @param mostOfNothing  Values that an accessor without bytes of its own may have.
[[nodiscard]] Result<GltfTriangles> checkGltf(std::string_view file, std::uint64_t mostOfNothing);

}  // namespace haptics
