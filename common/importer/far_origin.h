#pragma once

#include <string>

#include "common/maths/vec.h"
#include "common/mesh/import.h"

namespace haptics {

/// Positions that are far from the origin for the size of the box around all of them are made less by `centre`, the box's, so
/// that Assimp, which holds them in float32, keeps what the file has of them in float64. Nodes place what is `centre` more.
/// Nothing is changed, and `centre` is 0, where they are near, or the file also has shapes without positions of their own.
/// @param file  COLLADA, X3D, or the text of a 3MF's model; FBX, as text or binary, whose arrays are then not packed. Others:
///              nothing is changed.
[[nodiscard]] Vec3 moveToOrigin(std::string& file, MeshFormat format);

}  // namespace haptics
