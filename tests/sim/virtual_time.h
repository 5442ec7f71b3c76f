#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace haptics::sim {

inline constexpr std::uint64_t kMillisecond_ns = 1'000'000;
inline constexpr std::uint64_t kSecond_ns = 1'000'000'000;

/// The clock of a simulated world and what is still to happen in it. What falls on the same nanosecond happens in the
/// order in which it was asked for, so that a seed replays exactly.
class VirtualTime {
 public:
  [[nodiscard]] std::uint64_t now_ns() const noexcept { return now_ns_; }

  void after(std::uint64_t delay_ns, std::function<void()> task) {
    events_.push_back({now_ns_ + delay_ns, order_++, std::move(task)});
    std::ranges::push_heap(events_, later);
  }
  /// Does not happen when the owner is gone by then.
  void after(std::uint64_t delay_ns, std::weak_ptr<const void> owner, std::function<void()> task) {
    after(delay_ns, [owner = std::move(owner), task = std::move(task)] {
      if (const auto alive = owner.lock()) task();
    });
  }
  void runUntil(std::uint64_t time_ns) {
    while (!events_.empty() && events_.front().time_ns <= time_ns) {
      std::ranges::pop_heap(events_, later);
      const Event event = std::move(events_.back());
      events_.pop_back();
      now_ns_ = event.time_ns;
      event.task();
    }
    now_ns_ = time_ns;
  }

 private:
  struct Event {
    std::uint64_t time_ns;
    std::uint64_t order;
    std::function<void()> task;
  };
  static bool later(const Event& a, const Event& b) {
    return std::pair(a.time_ns, a.order) > std::pair(b.time_ns, b.order);
  }

  std::uint64_t now_ns_ = 0;
  std::uint64_t order_ = 0;
  std::vector<Event> events_;  // a heap, the next one in front
};

}  // namespace haptics::sim
