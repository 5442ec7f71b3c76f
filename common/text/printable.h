#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace haptics {

struct Utf8Character {
  char32_t code = 0;
  std::size_t bytes = 0;  ///< 0: what is there is not UTF-8.
};

/// The first of a text that is not empty.
[[nodiscard]] Utf8Character firstCharacterOf(std::string_view text);

/// Text that another party wrote, for a terminal, a log or a picture. Escaped are control characters (C0, DEL, C1), line
/// separators and what turns the direction of writing, as \x1b and \u202e, and bytes that are not UTF-8, as \xff. The
/// rest stays as it is.
[[nodiscard]] std::string printable(std::string_view text);

/// Text that another party wrote, for a message of protobuf: bytes that are not UTF-8, with which its receiver cannot read the
/// message, become \xff. The rest stays as it is.
[[nodiscard]] std::string asUtf8(std::string_view text);

}  // namespace haptics
