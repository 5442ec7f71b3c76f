#pragma once

namespace haptics::eval {

/// While it lives, Ctrl-C (SIGINT) and SIGTERM do not end the program but are remembered: a long run can stop in order
/// and keep what it has.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  [[nodiscard]] bool came() const noexcept;
  /// Sleeps this long, or until it comes.
  void sleep(double seconds) const;

 private:
  void (*onInterrupt_)(int);  // what there was before
  void (*onTerminate_)(int);
};

}  // namespace haptics::eval
