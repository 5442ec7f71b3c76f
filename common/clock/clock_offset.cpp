#include "common/clock/clock_offset.h"

#include <algorithm>
#include <numeric>

namespace haptics {

void ClockOffset::add(std::uint64_t clientSend, std::uint64_t serverReceive, std::uint64_t serverSend,
                      std::uint64_t clientReceive) {
  if (std::max({clientSend, serverReceive, serverSend, clientReceive}) > kLatest_ns) return;
  const auto difference = [](std::uint64_t a, std::uint64_t b) { return static_cast<std::int64_t>(a - b); };
  const std::size_t slot = count_++ % kWindow;
  offsets_[slot] = (difference(serverReceive, clientSend) + difference(serverSend, clientReceive)) / 2;
  roundTrips_[slot] = difference(clientReceive, clientSend) - difference(serverSend, serverReceive);

  // Quickest first: those waited least behind other bytes, which wait one way more than the other.
  const std::size_t filled = std::min(count_, kWindow);
  std::array<std::size_t, kWindow> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(filled), {},
                    [this](std::size_t i) { return roundTrips_[i]; });
  const std::size_t quick = (filled + kWindow / kQuickest - 1) / (kWindow / kQuickest);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(quick / 2);
  std::ranges::nth_element(order.begin(), middle, order.begin() + static_cast<std::ptrdiff_t>(quick), {},
                           [this](std::size_t i) { return offsets_[i]; });
  offset_ = offsets_[*middle];
  smallestRoundTrip_ =
      *std::min_element(roundTrips_.begin(), roundTrips_.begin() + static_cast<std::ptrdiff_t>(filled));
}

}  // namespace haptics
