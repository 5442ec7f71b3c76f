#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>

#include "tests/stress/run_plan.h"

namespace haptics::stress {

/// What becomes of a packet. One way: half the round trip, with normally distributed jitter (standard deviation
/// jitter_ms, cut off at three of them), independent from packet to packet, so that packets overtake one another.
class Impairment {
 public:
  explicit Impairment(const RunPlan& plan) : plan_(plan), random_(plan.seed) {}

  /// When it arrives; nothing: never.
  [[nodiscard]] std::optional<std::uint64_t> arrival_ns(std::uint64_t now_ns) {
    if (plan_.cutAt(now_ns) || std::uniform_real_distribution(0.0, 100.0)(random_) < plan_.loss_pct)
      return std::nullopt;
    return now_ns + delay_ns();
  }
  [[nodiscard]] std::uint64_t delay_ns() {
    const double jitter_ms = std::min(normal_(random_), 3.0) * plan_.jitter_ms;
    return static_cast<std::uint64_t>(std::max(0.0, plan_.rtt_ms / 2 + std::max(jitter_ms, -3 * plan_.jitter_ms)) *
                                      1e6);
  }
  [[nodiscard]] bool lost() { return std::uniform_real_distribution(0.0, 100.0)(random_) < plan_.loss_pct; }

 private:
  const RunPlan& plan_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace haptics::stress
