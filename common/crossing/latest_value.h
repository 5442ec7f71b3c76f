#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace haptics {

/// The newest of a thread's values, for one other thread: what it did not take in time is replaced. Three places: one is
/// written, one read, and the third holds the newest between them. One writer, one reader.
template <class Value>
class LatestValue {
 public:
  static_assert(std::is_trivially_copyable_v<Value>, "crosses threads by copy");
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

  /// Writer, wait-free.
  void put(const Value& value) noexcept {
    places_[writing_] = value;
    const std::uint8_t was = newest_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel);
    writing_ = was & kPlace;
  }

  /// Reader, wait-free. The newest value; null when it was taken before. Valid until the next call.
  [[nodiscard]] const Value* take() noexcept {
    if ((newest_.load(std::memory_order_relaxed) & kFresh) == 0) return nullptr;
    reading_ = newest_.exchange(reading_, std::memory_order_acq_rel) & kPlace;
    return &places_[reading_];
  }

 private:
  static constexpr std::uint8_t kPlace = 3;
  static constexpr std::uint8_t kFresh = 4;

  std::array<Value, 3> places_{};
  std::uint8_t writing_ = 0;             // writer only
  std::atomic<std::uint8_t> newest_{1};  // a place, and whether it is new
  std::uint8_t reading_ = 2;             // reader only
};

}  // namespace haptics
