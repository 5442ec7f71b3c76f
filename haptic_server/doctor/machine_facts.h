#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptics {

/// What the machine says of itself, as far as a real-time servo depends on it. Empty: it does not say.
struct MachineFacts {
  // This process:
  std::uint64_t maxPriority = 0;           ///< rtprio limit.
  std::uint64_t lockableMemory_bytes = 0;  ///< memlock limit.
  bool mayRaisePriority = false;           ///< CAP_SYS_NICE: maxPriority does not bind.
  bool mayLockMemory = false;              ///< CAP_IPC_LOCK: lockableMemory_bytes does not bind.
  bool mayRequestLatency = false;          ///< /dev/cpu_dma_latency can be written.

  // The machine:
  std::string kernel;      ///< Release.
  std::string preemption;  ///< "PREEMPT_RT", "PREEMPT", "PREEMPT_DYNAMIC", "none".
  bool virtualMachine = false;
  int processors = 0;
  std::string isolated;                ///< List of processors that ordinary programs stay away from.
  std::vector<std::string> governors;  ///< Of the processors' frequencies, each once.
  std::string clockSource;
  std::string largePages;                        ///< "always", "madvise" or "never".
  std::optional<std::int64_t> realTimeShare_us;  ///< Of each second that real-time threads may use; -1: all.
  std::optional<std::int64_t> usbAutosuspend_s;  ///< -1: devices stay awake.
};

/// Reads them from /proc, /sys and /dev below `root`, and this process's limits.
[[nodiscard]] MachineFacts readMachineFacts(const std::filesystem::path& root = "/");

}  // namespace haptics
