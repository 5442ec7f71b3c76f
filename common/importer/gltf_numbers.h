#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/error/error.h"
#include "common/importer/include_reader.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// The name of the file with the positions that preparedGltf() has made float32.
inline constexpr const char* kGltfPositions = "float32 positions";

/// And of a binary file's buffer without a name.
inline constexpr const char* kGltfBinary = "binary chunk";

/// "%20" as " ".
[[nodiscard]] std::string withoutPercents(const std::string& uri);

/// A glTF 2.0 file as Assimp reads it rightly: a text.
struct Gltf {
  std::string file;
  std::string binary = {};                                ///< What kGltfBinary holds.
  std::string positions;                                  ///< What kGltfPositions holds.
  std::optional<std::uint64_t> triangles = std::nullopt;  ///< Of the shown meshes, each once; none: not said (Draco).
  std::uint64_t skipped = 0;                              ///< Primitives without positions.
  LeftOut leftOut;  ///< Skins and morphs that are as stored, copies, meshes that are not shown.
};

/// Looks at what a glTF 2.0 file (JSON, or binary) claims, before anything believes it, and leaves out of it what cannot be
/// felt and has to be right for Assimp: materials, textures, attributes beside positions; and what is hidden. Quantized
/// positions, and those that skins and weights move (GltfPose), become float32. Refused: no JSON, another version's binary, an
/// extension that is required and moves the geometry, fields that are not as the format has them (GltfFields), more values than
/// the file has bytes for.
/// @param mostOfNothing  Values that an accessor without bytes of its own may have.
[[nodiscard]] Result<Gltf> preparedGltf(std::string file, std::uint64_t mostOfNothing,
                                        const IncludeReader& readIncluded);

}  // namespace haptics
