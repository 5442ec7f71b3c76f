#pragma once

#include <optional>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// Refused, naming object, vertex or triangle and attribute: numbers that are none or missing, which Assimp takes for 0; transforms
/// without twelve of them; two objects of one id; an object that is a component of itself; a unit that 3MF does not have.
/// @param text  A model as plainXml() makes it.
[[nodiscard]] Result<void> checkModel3mf(std::string_view text);

/// Metres; millimetres where it is not said. Nothing: 3MF does not have it. Source: 3MF Core Specification 1.3, section 3.4.
/// @param word  In upper or lower case.
[[nodiscard]] std::optional<double> unitOf3mf(std::string_view word);

}  // namespace haptics
