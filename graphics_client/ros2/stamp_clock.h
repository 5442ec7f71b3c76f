#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace haptics {

/// Times of the server's monotonic clock as times since 1970 of this machine, which are those of ROS 2's nodes. What is known of
/// the difference changes a little all the time; stamps do not jump for that.
class StampClock {
 public:
  /// Differences from here on are a clock that was set, or another server's: followed at once.
  static constexpr std::int64_t kJump_ns = 50'000'000;
  /// Smaller ones are followed so slowly: time then passes at a thousandth more or less. Faster would show in derivatives.
  static constexpr std::int64_t kSlowness = 1000;

  /// @param difference_ns  Since 1970 minus server's, as known by now. @param now_ns  A monotonic clock of this machine.
  void learn(std::int64_t difference_ns, std::uint64_t now_ns) noexcept {
    const std::int64_t off = difference_ns - difference_ns_;
    if (!known_ || std::abs(off) >= kJump_ns) {
      difference_ns_ = difference_ns;
    } else {
      const std::int64_t most = static_cast<std::int64_t>(now_ns - learned_ns_) / kSlowness;
      difference_ns_ += std::clamp(off, -most, most);
    }
    known_ = true;
    learned_ns_ = now_ns;
  }

  /// Since 1970.
  [[nodiscard]] std::int64_t stamp_ns(std::uint64_t server_ns) const noexcept {
    return static_cast<std::int64_t>(server_ns) + difference_ns_;
  }

 private:
  bool known_ = false;
  std::int64_t difference_ns_ = 0;
  std::uint64_t learned_ns_ = 0;
};

}  // namespace haptics
