#pragma once

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <ctime>
#include <mutex>
#include <utility>
#include <vector>

namespace haptics {

/// What a piece of work takes of processors and of the heap, in all threads that are at it. May be asked by any thread.
class WorkMeter {
 public:
  /// While it lives, what the calling thread does counts for the meter, which outlives it; null counts nothing. The innermost
  /// one counts.
  class Counting {
   public:
    explicit Counting(WorkMeter* meter) : meter_(meter), outer_(std::exchange(current_, nullptr)) {
      if (meter_ != nullptr) meter_->begin();
      current_ = meter_;
    }
    ~Counting() {
      current_ = nullptr;
      if (meter_ != nullptr) meter_->end();
      current_ = outer_;
    }
    Counting(const Counting&) = delete;
    Counting& operator=(const Counting&) = delete;

   private:
    WorkMeter* const meter_;
    WorkMeter* const outer_;
  };

  WorkMeter() = default;
  WorkMeter(const WorkMeter&) = delete;
  WorkMeter& operator=(const WorkMeter&) = delete;

  /// That of the calling thread, for those that work for it; null: nothing counts.
  [[nodiscard]] static WorkMeter* current() noexcept { return current_; }
  /// Called by the hooks of the heap (heap_hooks_*.cpp): allocated, or freed where it is negative.
  static void heapGrew(std::int64_t bytes) noexcept {
    if (current_ != nullptr) current_->held_bytes_.fetch_add(bytes, std::memory_order_relaxed);
  }

  /// Of processors, so far.
  [[nodiscard]] double time_s() const {
    const std::lock_guard lock(mutex_);
    double sum_s = ended_s_;
    for (const Thread& thread : threads_) sum_s += timeOf_s(thread.clock) - thread.begun_s;
    return sum_s;
  }
  /// Allocated and not freed so far; 0 in programs without the hooks.
  [[nodiscard]] std::int64_t held_bytes() const noexcept { return held_bytes_.load(std::memory_order_relaxed); }

 private:
  struct Thread {
    pthread_t thread;
    clockid_t clock;
    double begun_s;
  };
  static inline constinit thread_local WorkMeter* current_ = nullptr;

  std::atomic<std::int64_t> held_bytes_{0};
  mutable std::mutex mutex_;  // guards the two below
  std::vector<Thread> threads_;
  double ended_s_ = 0;

  static double timeOf_s(clockid_t clock) noexcept {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  void begin() {
    clockid_t clock{};
    pthread_getcpuclockid(pthread_self(), &clock);
    const std::lock_guard lock(mutex_);
    threads_.push_back({pthread_self(), clock, timeOf_s(clock)});
  }
  void end() {
    const std::lock_guard lock(mutex_);
    const auto own = std::ranges::find(threads_, pthread_self(), &Thread::thread);
    ended_s_ += timeOf_s(own->clock) - own->begun_s;
    threads_.erase(own);
  }
};

}  // namespace haptics
