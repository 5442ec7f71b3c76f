#pragma once

#include <cstddef>
#include <string>

namespace haptics {

/// With commas between the thousands: "16,384".
[[nodiscard]] std::string grouped(std::size_t number);

}  // namespace haptics
