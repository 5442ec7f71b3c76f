#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace haptics::stress {

/// What one run does, as all its processes know it. The host's monotonic clock is common to them.
struct RunPlan {
  int clients = 8;
  double rtt_ms = 200, jitter_ms = 25, loss_pct = 5;
  double cutEvery_s = 10, cut_ms = 300;
  double seconds = 600;
  double edits_Hz = 20;  ///< Of each client.
  std::uint64_t seed = 1;
  std::uint64_t began_ns = 0;  ///< Monotonic.

  /// Quiet and attack take turns, quiet first: at least twenty of each in a minute or more.
  [[nodiscard]] double block_s() const { return std::max(0.5, seconds / 40); }
  [[nodiscard]] std::uint64_t end_ns() const { return began_ns + static_cast<std::uint64_t>(seconds * 1e9); }
  [[nodiscard]] double secondsAt(std::uint64_t now_ns) const {
    return 1e-9 * static_cast<double>(static_cast<std::int64_t>(now_ns - began_ns));
  }
  [[nodiscard]] int blockAt(std::uint64_t now_ns) const {
    return static_cast<int>(std::floor(secondsAt(now_ns) / block_s()));
  }
  /// Edits, kills and stops happen in the attacks only; the network is as bad in the quiet.
  [[nodiscard]] bool attackAt(std::uint64_t now_ns) const {
    return now_ns >= began_ns && now_ns < end_ns() && blockAt(now_ns) % 2 == 1;
  }
  /// The line is cut at the end of each period.
  [[nodiscard]] bool cutAt(std::uint64_t now_ns) const { return cutPhase_s(now_ns) > cutEvery_s - cut_ms * 1e-3; }
  /// A cut shows at the receiver until what is sent at its end can have arrived.
  [[nodiscard]] bool cutShowsAt(std::uint64_t now_ns) const {
    const double late_s = 1e-3 * (rtt_ms / 2 + 3 * jitter_ms);
    return cutAt(now_ns) || cutAt(now_ns - static_cast<std::uint64_t>(late_s * 1e9));
  }

 private:
  [[nodiscard]] double cutPhase_s(std::uint64_t now_ns) const {
    return now_ns < began_ns || cut_ms <= 0 || cutEvery_s <= 0 ? -1 : std::fmod(secondsAt(now_ns), cutEvery_s);
  }
};

/// The command line of a child that gets the plan, and back.
[[nodiscard]] std::vector<std::string> toArguments(const RunPlan& plan);

}  // namespace haptics::stress
