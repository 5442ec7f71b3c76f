#pragma once

#include <map>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// What `haptic_eval advise` says of the scene's objects, in a sentence each, by name. Refused: the records are none of it.
/// @param records  Its advise.json.
[[nodiscard]] Result<std::map<std::string, std::string>> adviceIn(const std::string& records);

}  // namespace haptics
