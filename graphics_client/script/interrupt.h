#pragma once

namespace haptics {

/// While it lives, the first Ctrl-C only makes interrupted() true; the second ends the program, as does the first
/// outside of such a life.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool interrupted() noexcept;
};

}  // namespace haptics
