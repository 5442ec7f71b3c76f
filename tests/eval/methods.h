#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "tests/eval/renderer.h"

namespace haptics::eval {

struct Method {
  std::string_view name;
  std::string_view about;
  std::unique_ptr<Renderer> (*make)();
};

inline constexpr std::string_view kOurs = "ours";

/// Ours first, then the baselines.
[[nodiscard]] std::span<const Method> methods();

}  // namespace haptics::eval
