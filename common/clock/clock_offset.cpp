#include "common/clock/clock_offset.h"

#include <algorithm>

namespace haptics {

void ClockOffset::add(std::uint64_t clientSend, std::uint64_t serverReceive, std::uint64_t serverSend,
                      std::uint64_t clientReceive) {
  const auto difference = [](std::uint64_t a, std::uint64_t b) { return static_cast<std::int64_t>(a - b); };
  const std::size_t slot = count_++ % kWindow;
  offsets_[slot] = (difference(serverReceive, clientSend) + difference(serverSend, clientReceive)) / 2;
  roundTrips_[slot] = difference(clientReceive, clientSend) - difference(serverSend, serverReceive);

  const std::size_t filled = std::min(count_, kWindow);
  auto sorted = offsets_;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(filled);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(filled / 2);
  std::nth_element(sorted.begin(), middle, end);
  median_ = *middle;
  smallestRoundTrip_ =
      *std::min_element(roundTrips_.begin(), roundTrips_.begin() + static_cast<std::ptrdiff_t>(filled));
}

}  // namespace haptics
