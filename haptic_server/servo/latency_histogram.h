#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace haptics {

/// Counts durations in buckets of 1/32 of their power of two (3 % wide), nanoseconds to centuries, in 15 KiB.
/// One thread records (wait-free, no allocation); any thread reads at any time and may miss the newest.
class LatencyHistogram {
 public:
  void record(std::uint64_t ns) noexcept {
    increment(counts_[bucketOf(ns)]);
    if (ns > max_.load(std::memory_order_relaxed)) max_.store(ns, std::memory_order_relaxed);
  }

  /// The duration that this part (0 to 1) of the records does not exceed, rounded up to its bucket's end; 0 when empty.
  [[nodiscard]] std::uint64_t quantile_ns(double part) const noexcept {
    std::uint64_t total = 0;
    for (const auto& count : counts_) total += count.load(std::memory_order_relaxed);
    const auto wanted = static_cast<std::uint64_t>(std::ceil(part * static_cast<double>(total)));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i].load(std::memory_order_relaxed);
      if (seen > 0 && seen >= wanted) return std::min(endOf(i), max_ns());
    }
    return 0;
  }
  [[nodiscard]] std::uint64_t max_ns() const noexcept { return max_.load(std::memory_order_relaxed); }

 private:
  static constexpr unsigned kSubBits = 5;
  static constexpr std::uint64_t kSub = 1U << kSubBits;

  // Below kSub a bucket a nanosecond; above, kSub buckets to each power of two.
  [[nodiscard]] static std::size_t bucketOf(std::uint64_t ns) noexcept {
    if (ns < kSub) return ns;
    const unsigned shift = static_cast<unsigned>(std::bit_width(ns)) - kSubBits - 1;
    return (shift + 1) * kSub + ((ns >> shift) - kSub);
  }
  [[nodiscard]] static std::uint64_t endOf(std::size_t bucket) noexcept {
    if (bucket < kSub) return bucket;
    const std::size_t shift = bucket / kSub - 1;
    return ((bucket % kSub + kSub + 1) << shift) - 1;
  }
  static void increment(std::atomic<std::uint64_t>& count) noexcept {
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, (64 - kSubBits + 1) * kSub> counts_{};
  std::atomic<std::uint64_t> max_{0};
};

}  // namespace haptics
