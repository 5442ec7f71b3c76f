#pragma once

#include <stdexcept>
#include <stop_token>
#include <utility>

// Long work that may be cancelled: whoever starts it makes an Interruptible, and what takes long looks now and then
// whether it is still wanted. What nobody makes interruptible runs to its end.
namespace haptics {

/// Thrown where cancelled work ends.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("it was cancelled") {}
};

/// While it lives, the token stops this thread's work; the innermost one counts.
class Interruptible {
 public:
  explicit Interruptible(std::stop_token token) : outer_(std::exchange(current_, std::move(token))) {}
  ~Interruptible() { current_ = std::move(outer_); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  /// The calling thread's stop token.
  [[nodiscard]] static const std::stop_token& token() noexcept { return current_; }

 private:
  static inline thread_local std::stop_token current_;
  std::stop_token outer_;
};

/// Throws Interrupted when this thread's work is to end. Costs a few nanoseconds.
inline void interruptionPoint() {
  if (Interruptible::token().stop_requested()) throw Interrupted();
}

}  // namespace haptics
