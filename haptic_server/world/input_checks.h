#pragma once

#include <array>
#include <cstdio>
#include <string>

#include "haptic_server/world/world.h"

namespace haptics {

[[noreturn]] inline void refuse(const std::string& field, const std::string& reason) {
  throw InvalidInput(field + ": " + reason);
}

[[nodiscard]] inline std::string text(double value) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%g", value);
  return digits.data();
}

inline void check(double value, double least, double most, const char* unit, const char* field) {
  if (value >= least && value <= most) return;  // not for NaN
  refuse(field, "is " + text(value) + "; it is to be from " + text(least) + " to " + text(most) + unit);
}

}  // namespace haptics
