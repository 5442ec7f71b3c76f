#pragma once

#include <algorithm>
#include <cstdint>

#include "haptic_server/net/rate_limit.h"

namespace haptics {

/// Lets one client's edits through at a bounded rate and in their order. After an edit that came too early all later
/// numbers come too early as well, until one of those that were put off comes again: a client sends them again in
/// order, once it has the answer to each.
class EditGate {
 public:
  /// How long a client is to wait.
  static constexpr std::uint32_t kRetryAfter_ms = 100;

  EditGate(double perSecond, double burst) noexcept : rate_(perSecond, burst) {}

  /// Whether the edit may pass now; else it is put off.
  [[nodiscard]] bool allow(std::uint64_t clientSeq, std::uint64_t now_ns) noexcept {
    if (clientSeq <= retryUpTo_) retryUpTo_ = 0;
    if (retryUpTo_ == 0 && rate_.allow(now_ns)) return true;
    retryLater(clientSeq);
    return false;
  }
  /// It passed, and there was no room for it.
  void retryLater(std::uint64_t clientSeq) noexcept { retryUpTo_ = std::max(retryUpTo_, clientSeq); }

 private:
  RateLimit rate_;
  std::uint64_t retryUpTo_ = 0;  // highest number that came too early, and was not let in since
};

}  // namespace haptics
