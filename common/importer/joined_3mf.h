#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"

namespace haptics {

struct Model3mf {
  std::string name, text;  ///< As in the archive.
};

/// Names of a package's parts are one in upper and lower case (ECMA-376-2, 6.2.2.3).
[[nodiscard]] bool isOnePath(std::string_view a, std::string_view b);

/// The first model with the objects of the others put into it that it names, since Assimp reads one (3MF Production Extension
/// 1.1, 4: a component or an item says by its path which model its object is in). Properties of the others are left out.
/// Refused: a model that is not there, another unit.
[[nodiscard]] Result<std::string> joined(std::vector<Model3mf> models);

}  // namespace haptics
