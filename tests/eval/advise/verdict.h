#pragma once

#include <string>

#include "tests/eval/advise/advice.h"

namespace haptics::eval {

/// Sets the advised mesh and the verdict: of the candidates the coarsest of which it and all finer ones are good, where it
/// saves 0.1 MB, or 5 % of the tick (50 ns or more) with hot caches and with cold ones, and where nothing of the object goes by the numbers
/// of its vertices or by a shape that was not judged; else its own.
/// @param object  Index into the scene.
void decide(ObjectAdvice& advice, const std::vector<LoadedObject>& scene, std::size_t object);

/// Of a tool, which keeps its mesh: "keep; held as a tool, its points may be 2 mm apart".
[[nodiscard]] std::string verdictOf(const ToolAdvice& tool);

/// The file of an object's advised mesh: NAME.ply.
[[nodiscard]] std::string meshFileOf(const ObjectAdvice& object);

}  // namespace haptics::eval
