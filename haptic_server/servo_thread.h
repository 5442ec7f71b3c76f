#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "common/log/log.h"
#include "haptic_server/servo/realtime.h"

namespace haptics {

/// The servo's thread, and what the machine grants it.
class ServoThread {
 public:
  ~ServoThread() { stop(); }

  /// Before the threads that drive devices start.
  /// @param lock  Whether the process's memory is to be locked.
  void prepare(bool lock) {
    if (lock) lockMemory(realtime_);
    idleInhibitor_.emplace(realtime_);
  }
  /// Runs the servo until stop(); returns once the thread is a real-time one, as far as may be. Logs what was not granted.
  /// @param cpu  To bind it to; nothing: none.
  void start(std::optional<int> cpu, std::function<void(const std::atomic<bool>& stop)> run) {
    thread_ = std::thread([this, cpu, run = std::move(run)] {
      configureServoThread(cpu, realtime_);
      ready_.store(true);
      ready_.notify_one();
      run(stop_);
    });
    ready_.wait(false);
    if (realtime_.memoryLocked) lockMemoryAsItIsWritten();
    for (const std::string& warning : realtime_.warnings) logWarning(warning);
  }
  /// Asks it to end, and waits for that.
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  [[nodiscard]] const RealtimeStatus& realtime() const noexcept { return realtime_; }  ///< Once it runs.

 private:
  RealtimeStatus realtime_;
  std::optional<CpuIdleInhibitor> idleInhibitor_;
  std::atomic<bool> ready_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptics
