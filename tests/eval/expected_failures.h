#pragma once

#include <array>
#include <string_view>

namespace haptics::eval {

struct Expectation {
  std::string_view method;
  std::string_view scenes;  ///< That it fails, each followed by a space. A method that is not listed fails none.
};

/// What each baseline is expected to fail, and why. A scene that everything passes would be a broken test; so would be
/// one that a correct god-object has to fail.
inline constexpr std::array<Expectation, 0> kExpectedFailures{};

}  // namespace haptics::eval
