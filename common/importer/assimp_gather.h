#pragma once

#include <string>

#include "common/error/error.h"
#include "common/importer/include_reader.h"
#include "common/mesh/import.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Reads a file of a format whose reader is kAssimp, with Assimp, and takes the faces of all its meshes, or of the part that is
/// asked for, where the nodes place them: the coordinates of the file's root, its own axes, counter-clockwise seen from outside.
/// Debian's Assimp holds vertices in float32, and so those of COLLADA, 3MF, FBX and X3D are read relative to their middle where
/// they are far from the origin for their size; transforms are applied in double, but are float32 each. Points, lines, animations,
/// what is hidden and, but for glTF, skins and morph targets are left out and counted. Refused, by name: fields and numbers that
/// are not as the format has them, or that the file's bytes cannot stand for; few bytes that repeat themselves to very many
/// triangles; a part that is not there, naming those that are. What else the reader refuses, in its words.
/// Opens no file: a glTF's buffers come from `readIncluded`. Not for use in a server: Assimp may crash on a damaged file.
[[nodiscard]] Result<PolygonSoup> gatherByAssimp(std::string file, MeshFormat format, const PartName& part,
                                                 const IncludeReader& readIncluded);

}  // namespace haptics
