#pragma once

#include <functional>

namespace haptics::eval {

/// Instructions that `work` executes in user space, counted one by one by the processor's trap flag: exactly repeatable,
/// a thousand times slower than the work, and needs no hardware counters, which virtual machines seldom have. x86-64. Not
/// under a debugger or valgrind.
[[nodiscard]] double countInstructions(const std::function<void()>& work);

}  // namespace haptics::eval
