#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace haptics::eval {

/// How a line treats packets, one way.
struct LineQuality {
  double delay_s = 0;
  double jitter_s = 0;  ///< At most, besides; packets may overtake one another.
  double lost = 0;      ///< Share.
};

/// A line in virtual time, one way.
template <class Packet>
class Line {
 public:
  Line(const LineQuality& quality, std::uint64_t seed) : quality_(quality), random_(seed) {}

  void put(double now_s, const Packet& packet) {
    ++sent_;
    const double late = share_(random_), fate = share_(random_);
    if (fate >= quality_.lost) underway_.emplace_back(now_s + quality_.delay_s + late * quality_.jitter_s, packet);
  }
  /// Gives what has come by now, the earliest first.
  template <class Take>
  void take(double now_s, const Take& take) {
    const auto left = std::stable_partition(underway_.begin(), underway_.end(),
                                            [now_s](const auto& due) { return due.first <= now_s; });
    std::stable_sort(underway_.begin(), left, [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto due = underway_.begin(); due != left; ++due) take(due->second);
    underway_.erase(underway_.begin(), left);
  }
  [[nodiscard]] long sent() const noexcept { return sent_; }

 private:
  LineQuality quality_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> share_{0, 1};
  std::vector<std::pair<double, Packet>> underway_;
  long sent_ = 0;
};

}  // namespace haptics::eval
