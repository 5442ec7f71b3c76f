#pragma once

#include <cstdint>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// Takes their meshes from the objects of a 3DS that are hidden (OBJ_HIDDEN, 0x4010), which Assimp shows. Their number. Refused: no
/// 3DS, or a chunk of more bytes than there are.
[[nodiscard]] Result<std::uint64_t> checked3ds(std::string& file);

}  // namespace haptics
