#pragma once

#include <optional>
#include <string>
#include <vector>

namespace haptics {

/// What the machine granted.
struct RealtimeStatus {
  bool fifo = false;
  bool memoryLocked = false;
  bool pinned = false;
  std::vector<std::string> warnings;  ///< In plain words, with what would help.
};

/// Locks the process's memory, now and to come, so that the servo takes no page fault. Once, before threads start.
void lockMemory(RealtimeStatus& status);

/// Makes the calling thread a real-time one (SCHED_FIFO) and, where asked, binds it to one CPU. Also touches the stack
/// that the servo will use.
void becomeServoThread(std::optional<int> cpu, RealtimeStatus& status);

}  // namespace haptics
