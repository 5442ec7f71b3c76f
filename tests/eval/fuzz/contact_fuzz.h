#pragma once

#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/methods.h"

namespace haptics::eval {

/// runFuzzContact() of another method, whose findings are not reduced.
[[nodiscard]] bool runFuzzContactOf(const Method& method, const FuzzOptions& options, const std::filesystem::path& out);

}  // namespace haptics::eval
