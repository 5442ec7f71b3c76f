#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace haptics {

/// A mailbox for one writer and one reader thread that holds the newest value only. Three places: the writer's, the
/// reader's, and one between them that they swap theirs for.
template <class Value>
class TripleBuffer {
  static_assert(std::is_trivially_copyable_v<Value>, "crosses threads by copy");

 public:
  /// The writer's thread. Wait-free.
  void put(const Value& value) noexcept {
    places_[writing_] = value;
    writing_ = between_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kPlace;
  }

  /// The reader's thread. Wait-free: the newest value that was put, Value{} before the first. Valid until the next call.
  [[nodiscard]] const Value& newest() noexcept {
    if (between_.load(std::memory_order_relaxed) & kFresh) {
      reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & kPlace;
    }
    return places_[reading_];
  }
  /// The same thread. Wait-free: null when nothing was put since the last call.
  [[nodiscard]] const Value* takeNew() noexcept {
    return between_.load(std::memory_order_relaxed) & kFresh ? &newest() : nullptr;
  }

 private:
  static constexpr std::uint8_t kFresh = 4, kPlace = 3;

  std::array<Value, 3> places_{};
  std::uint8_t writing_ = 0;  // the writer's
  std::uint8_t reading_ = 1;  // the reader's
  std::atomic<std::uint8_t> between_{2};
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);
};

}  // namespace haptics
