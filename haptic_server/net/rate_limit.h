#pragma once

#include <algorithm>
#include <cstdint>

namespace haptics {

/// A token bucket: `burst` at once, `perSecond` sustained.
class RateLimit {
 public:
  RateLimit(double perSecond, double burst) noexcept : perSecond_(perSecond), burst_(burst), tokens_(burst) {}

  /// Whether one more, or so many, may pass now. Times in ns, never going back.
  [[nodiscard]] bool allow(std::uint64_t now_ns, double count = 1) noexcept {
    tokens_ = std::min(burst_, tokens_ + static_cast<double>(now_ns - last_ns_) * 1e-9 * perSecond_);
    last_ns_ = now_ns;
    if (tokens_ < count) return false;
    tokens_ -= count;
    return true;
  }

 private:
  double perSecond_;
  double burst_;
  double tokens_;
  std::uint64_t last_ns_ = 0;
};

}  // namespace haptics
