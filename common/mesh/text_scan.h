#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/maths/vec.h"

namespace haptics {

/// Walks through the words of a text. Lines end with a line feed, a carriage return, or both; between words are blanks, tabs,
/// \v, \f and NUL. A copy goes on from the same place.
class TextScan {
 public:
  enum class Comments {
    kNone,
    kHash  ///< From '#' to the line's end; but not the '#' of "1.#IND", as Windows once wrote what is no number.
  };

  explicit TextScan(std::string_view text, Comments comments = Comments::kNone) : rest_(text), comments_(comments) {}

  /// The next word of this line; empty at its end.
  [[nodiscard]] std::string_view wordOfLine();
  /// The next word, on this line or a later one; empty at the end of the text.
  [[nodiscard]] std::string_view word();
  /// To the beginning of the next line.
  void skipLine();
  /// Takes the last bytes of the word that was just taken once more.
  void goBack(std::size_t bytes) { rest_ = {rest_.data() - bytes, rest_.size() + bytes}; }

  /// From 1: that of the word that was just taken.
  [[nodiscard]] std::uint64_t line() const { return line_; }
  /// What is left.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::size_t size() const { return rest_.size(); }

 private:
  [[nodiscard]] bool startsComment(std::size_t at) const;

  std::string_view rest_;
  std::uint64_t line_ = 1;
  Comments comments_;
};

/// As upper and lower case of ASCII are one; `lower` is in lower case.
[[nodiscard]] bool isWord(std::string_view word, std::string_view lower);
[[nodiscard]] std::string inLowerCase(std::string_view word);

/// The whole word as a decimal number, which may be infinite or NaN if it says so, as "nan", "inf", "-1.#IND" or "1.#QNAN";
/// its point may be a comma, and a comma or an "f" may end it. Nothing if it is not a number.
[[nodiscard]] std::optional<double> asNumber(std::string_view word);
[[nodiscard]] std::optional<std::int64_t> asInteger(std::string_view word);

/// Refused with the line where the scan is: "line 7: " and the reason.
[[nodiscard]] tl::unexpected<Error> refusedAt(const TextScan& scan, const std::string& reason);

/// The next three words as numbers. Refused, naming line and vertex, if one is missing or not a number.
/// @param acrossLines  They may be on several lines.
[[nodiscard]] Result<Vec3> nextPoint(TextScan& scan, std::uint64_t vertex, bool acrossLines);

/// Whether vertices that stand one to a line, save one, end within a line that by itself is a face, its number of corners and as
/// many words and `wordsAfter`: one of them has too few words, or there are fewer than is claimed.
/// @param vertices  Their text, up to where they end.
/// @param rest      What follows it.
[[nodiscard]] bool endsWithinFace(std::string_view vertices, std::string_view rest, std::size_t wordsOfVertex,
                                  std::size_t wordsAfter);

/// A word for an error message: quoted, shortened, without control characters.
[[nodiscard]] std::string inQuotes(std::string_view word);

}  // namespace haptics
