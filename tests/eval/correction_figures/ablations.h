#pragma once

#include <memory>
#include <string_view>

#include "tests/eval/renderer.h"

namespace haptics::eval {

/// The contact core with its spring, by the names of `haptic_eval failures`: ours, ours_float, ours_without_... Null when
/// there is none called so.
[[nodiscard]] std::unique_ptr<Renderer> makeAblation(std::string_view name);

}  // namespace haptics::eval
