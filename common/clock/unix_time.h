#pragma once

#include <chrono>
#include <cstdint>

namespace haptics {

/// Nanoseconds since 1970, for people: it may be set back.
[[nodiscard]] inline std::int64_t unixNow_ns() noexcept {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace haptics
