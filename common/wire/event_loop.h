#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace haptics {

/// A running timer; destroying it, which its own task may do, stops it: the task is not called any more.
class Timer {
 public:
  struct State;

  Timer();  ///< Stopped.
  explicit Timer(std::shared_ptr<State> state);
  ~Timer();
  Timer(Timer&&) noexcept;
  Timer& operator=(Timer&&) noexcept;

 private:
  std::shared_ptr<State> state_;
};

/// One thread's network events and timers: everything made with a loop calls back on the thread in run(), is used on
/// that thread only, and is destroyed before the loop. (Before run() and after it returned, any one thread will do.)
class EventLoop {
 public:
  struct Context;

  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// Serves events until stop(), also while there is nothing to serve.
  void run();
  /// run() returns after the event in hand. Any thread.
  void stop();
  /// Runs the task on the loop's thread, in the order of posting. Any thread.
  void post(std::function<void()> task);

  [[nodiscard]] Timer after(std::chrono::nanoseconds delay, std::function<void()> task);
  /// Times are multiples of the period after now; those that were missed are skipped, not made up for.
  [[nodiscard]] Timer every(std::chrono::nanoseconds period, std::function<void()> task);

  [[nodiscard]] Context& context() noexcept { return *context_; }  ///< For the transports of this folder.

 private:
  std::unique_ptr<Context> context_;
};

}  // namespace haptics
