#pragma once

#include <string>
#include <vector>

#include "common/error/error.h"

namespace haptics {

struct Model3mf {
  std::string name, text;  ///< As in the archive.
};

/// The first model with the objects of the others put into it that it names, since Assimp reads one (3MF Production Extension
/// 1.1, 4: a component or an item says by its path which model its object is in). Properties of the others are left out.
/// Refused: a model that is not there, another unit.
[[nodiscard]] Result<std::string> joined(std::vector<Model3mf> models);

}  // namespace haptics
