#include "haptic_server/servo_thread.h"

#include <string>
#include <utility>

#include "haptic_server/app_log.h"

namespace haptics {

void ServoThread::prepare(bool lock) {
  if (lock) lockMemory(realtime_);
  idleInhibitor_.emplace(realtime_);
}

void ServoThread::start(std::optional<int> cpu, std::function<void(const std::atomic<bool>& stop)> run) {
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

void ServoThread::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace haptics
