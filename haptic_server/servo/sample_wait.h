#pragma once

#include <cstdint>

namespace haptics {

/// How long a tick waits for a position that is late. A device on USB answers about half a period before the next tick, but
/// both sides' wake-ups jitter: without waiting, a tick would compute with the position of the one before, and the next
/// one would have two.
class SampleWait {
 public:
  explicit SampleWait(std::uint64_t period_ns) noexcept : period_ns_(period_ns) {}

  /// Whether the tick waits for another step_ns(). `waited_ns`: since it was due. A device that has let a tick go without a
  /// position is not waited for until there is one.
  [[nodiscard]] bool shouldWait(bool hasSample, std::uint64_t waited_ns) noexcept {
    const bool wait = !hasSample && hadLast_ && waited_ns + step_ns() <= longest_ns();
    if (!wait) hadLast_ = hasSample;
    return wait;
  }
  [[nodiscard]] std::uint64_t step_ns() const noexcept { return period_ns_ / 20; }
  /// Longer, and the device's next command would go out without this tick's force.
  [[nodiscard]] std::uint64_t longest_ns() const noexcept { return period_ns_ * 3 / 10; }

 private:
  std::uint64_t period_ns_;
  bool hadLast_ = false;
};

}  // namespace haptics
