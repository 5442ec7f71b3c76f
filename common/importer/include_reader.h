#pragma once

#include <functional>
#include <optional>
#include <string>

namespace haptics {

/// The bytes of a file that a file includes, by the name that it has there; nothing where it is to be left out.
using IncludeReader = std::function<std::optional<std::string>(const std::string& name)>;

}  // namespace haptics
