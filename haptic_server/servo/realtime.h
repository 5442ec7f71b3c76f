#pragma once

#include <optional>
#include <string>
#include <vector>

namespace haptics {

/// Real-time privileges that the system granted.
struct RealtimeStatus {
  bool fifo = false;
  bool memoryLocked = false;
  bool pinned = false;
  std::vector<std::string> warnings;  ///< In plain words, with what would help.
};

/// Threads that start from now on have stacks of 2 MB in place of the system's 8 MB: where memory is locked, each is there as
/// a whole from the beginning, used or not.
void keepStacksSmall();

/// Locks the process's memory, now and to come, so that the servo takes no page fault. Once, before threads start.
void lockMemory(RealtimeStatus& status);

/// After lockMemory(), once all that the servo alone writes is there: memory that comes later is locked page by page, as
/// whoever makes a scene writes it. All at once, a system call clears an array of a gigabyte for more than a second, which
/// cannot be cancelled, and in pages of 4 kB.
void lockMemoryAsItIsWritten();

/// While it lives the processors take no sleep from which they are slow to wake. Measured on a virtual machine: half the
/// wake-up latency (27 to 15 us p50 at 1 kHz), at the cost of idle processors that spin.
class CpuIdleInhibitor {
 public:
  explicit CpuIdleInhibitor(RealtimeStatus& status);
  ~CpuIdleInhibitor();
  CpuIdleInhibitor(const CpuIdleInhibitor&) = delete;
  CpuIdleInhibitor& operator=(const CpuIdleInhibitor&) = delete;

 private:
  int request_;  // holds while the file is open
};

/// Makes the calling thread, which drives a device, a real-time one, just below the servo's.
void configureDriverThread(RealtimeStatus& status);

/// Makes the calling thread a real-time one (SCHED_FIFO) and, where asked, binds it to one CPU. Also touches the stack
/// that the servo will use.
void configureServoThread(std::optional<int> cpu, RealtimeStatus& status);

}  // namespace haptics
