#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "common/error/error.h"
#include "common/interruption/work_meter.h"

namespace haptics {

/// What the work of one edit may take, whatever its price says. Larger keeps a worker from others for longer.
struct WorkLimits {
  double time_s = 10;         ///< Of processors, in all threads of this process that are at it.
  double memory_bytes = 2e9;  ///< Allocated and not freed.
};

/// While it lives, the calling thread's work is looked at every kEvery, by a thread of its own.
class WorkWatch {
 public:
  static constexpr std::chrono::milliseconds kEvery{50};

  /// \param stop  Called once, on that thread: the work takes more than it may, or `isEnough`, which may be empty, says so.
  WorkWatch(const WorkLimits& limits, std::function<void()> stop, std::function<bool()> isEnough = {});

  /// Why the work is to be refused, if it has taken more than it may: also where it has freed that since.
  [[nodiscard]] std::optional<Error> tooMuch();

 private:
  const WorkLimits limits_;
  WorkMeter meter_;
  const WorkMeter::Counting counting_{&meter_};
  std::mutex mutex_;  // guards the next
  std::optional<Error> exceeded_;
  const std::jthread thread_;  // last: it uses the others

  void watch(const std::stop_token& done, const std::function<void()>& stop, const std::function<bool()>& isEnough);
  [[nodiscard]] std::optional<Error> measure() const;
};

}  // namespace haptics
