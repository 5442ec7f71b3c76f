#pragma once

#include <cstdint>

#include "common/error/error.h"

namespace haptics {

/// Makes this process one that may be lost: it ends with the thread that started it, is the first to end where memory
/// runs out, leaves the processors to others, has no capabilities and gains none, writes no file and no core, opens no
/// more than a few, and gets no more than `processorTime_s` of a processor and no more memory than importing the largest
/// mesh takes, half of what the machine has at the most. For the beginning of a program.
void lowerPriorityAndLimit(unsigned processorTime_s);

/// No more memory than this from now on, if that is less; and `onTime` is called by a signal once it has had so much of a
/// processor, and then every second.
void limitMore(std::uintmax_t memory_bytes, unsigned processorTime_s, void (*onTime)(int));

/// From now on this process may use what it holds, memory and open files, and nothing else: opening a file fails,
/// every other system call ends it. For good. Refused where the kernel cannot filter system calls.
[[nodiscard]] Result<void> enterSandbox();

}  // namespace haptics
