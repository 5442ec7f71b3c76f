#pragma once

#include <functional>
#include <optional>

namespace haptics::eval {

/// Instructions that `work` executes in user space, counted one by one: a copy of this process runs it under a tracer.
/// Exactly repeatable, a million times slower than the work, changes nothing here. Empty where tracing is not permitted.
[[nodiscard]] std::optional<double> countInstructions(const std::function<void()>& work);

}  // namespace haptics::eval
