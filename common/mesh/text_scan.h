#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/maths/vec.h"

namespace haptics {

/// Cuts the next line off `rest`, without its line feed; carriage returns count as white space below.
[[nodiscard]] std::string_view nextLine(std::string_view& rest);

/// Cuts the next word off `rest`; empty at the end. White space: blank, tab, line feed, carriage return, \v, \f.
[[nodiscard]] std::string_view nextWord(std::string_view& rest);

/// The whole word as a decimal number, which may be infinite or NaN if it says so; nothing if it is not a number.
[[nodiscard]] std::optional<double> asNumber(std::string_view word);
[[nodiscard]] std::optional<std::int64_t> asInteger(std::string_view word);

/// As float32. Refused, naming the vertex, if it is not finite or too large.
[[nodiscard]] Result<float> coordinate(double value, std::uint64_t vertex);
/// The next three words of `rest`, likewise. Refused too if one is missing or not a number.
[[nodiscard]] Result<Vec3> nextPoint(std::string_view& rest, std::uint64_t vertex);

/// A word for an error message: quoted, shortened, without control characters.
[[nodiscard]] std::string inQuotes(std::string_view word);

}  // namespace haptics
