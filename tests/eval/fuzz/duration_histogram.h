#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace haptics::eval {

/// Of any number of durations, in ns: quantiles to within a part in 32, the largest exactly.
class DurationHistogram {
 public:
  void add(double ns) {
    ++counts_[bucketOf(ns)];
    ++total_;
    largest_ns_ = std::max(largest_ns_, ns);
  }
  /// The value that this part (0 to 1) of them does not exceed; 0 when there are none.
  [[nodiscard]] double quantile_ns(double part) const {
    const auto wanted = static_cast<std::uint64_t>(part * static_cast<double>(total_));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i];
      if (seen > wanted) return std::min(largest_ns_, std::exp2(static_cast<double>(i + 1) / kPerOctave));
    }
    return largest_ns_;
  }
  [[nodiscard]] double largest_ns() const { return largest_ns_; }

 private:
  static constexpr int kPerOctave = 32;
  static constexpr std::size_t kBuckets = 40 * kPerOctave;
  [[nodiscard]] static std::size_t bucketOf(double ns) {
    return std::min(kBuckets - 1, static_cast<std::size_t>(kPerOctave * std::log2(std::max(1.0, ns))));
  }

  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t total_ = 0;
  double largest_ns_ = 0;
};

}  // namespace haptics::eval
