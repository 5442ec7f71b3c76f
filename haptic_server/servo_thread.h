#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <thread>

#include "haptic_server/servo/realtime.h"

namespace haptics {

/// The servo's thread, and what the machine grants it.
class ServoThread {
 public:
  ~ServoThread() { stop(); }

  /// Before the threads that drive devices start.
  /// @param lock  Whether the process's memory is to be locked.
  void prepare(bool lock);
  /// Runs the servo until stop(); returns once the thread is a real-time one, as far as may be. Logs what was not granted.
  /// @param cpu  To bind it to; nothing: none.
  void start(std::optional<int> cpu, std::function<void(const std::atomic<bool>& stop)> run);
  /// Asks it to end, and waits for that.
  void stop();

  [[nodiscard]] const RealtimeStatus& realtime() const noexcept { return realtime_; }  ///< Once it runs.

 private:
  RealtimeStatus realtime_;
  std::optional<CpuIdleInhibitor> idleInhibitor_;
  std::atomic<bool> ready_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptics
