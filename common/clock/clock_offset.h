#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace haptics {

/// Estimates server clock minus client clock from probe round trips (four timestamps): the median offset of the quickest
/// quarter of the last kWindow. The quickest, because over a TCP connection with losses a reply waits behind telemetry
/// that is sent again, one way only (the median of all was off by 70 ms there); a quarter of them, because jitter is in
/// those too. The true offset is within half the smallest round trip of it.
class ClockOffset {
 public:
  static constexpr std::size_t kWindow = 64;
  static constexpr std::size_t kQuickest = 16;  ///< Of a full window.
  /// 73 years of a monotonic clock. A reply with a later time is ignored.
  static constexpr std::uint64_t kLatest_ns = 1ULL << 61;

  /// Times in nanoseconds, client send and receive on the client's clock, server's on the server's.
  void add(std::uint64_t clientSend, std::uint64_t serverReceive, std::uint64_t serverSend,
           std::uint64_t clientReceive);

  [[nodiscard]] bool known() const noexcept { return count_ > 0; }
  [[nodiscard]] std::int64_t offset_ns() const noexcept { return offset_; }
  [[nodiscard]] std::int64_t uncertainty_ns() const noexcept { return smallestRoundTrip_ / 2; }
  /// A server time on the client's clock.
  [[nodiscard]] std::int64_t toClient_ns(std::uint64_t server_ns) const noexcept {
    return static_cast<std::int64_t>(std::min(server_ns, kLatest_ns)) - offset_;
  }

 private:
  std::array<std::int64_t, kWindow> offsets_{};
  std::array<std::int64_t, kWindow> roundTrips_{};
  std::size_t count_ = 0;
  std::int64_t offset_ = 0;
  std::int64_t smallestRoundTrip_ = 0;
};

}  // namespace haptics
