#include "common/mesh/text_scan.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "common/text/printable.h"

namespace haptics {
namespace {

enum class Kind : std::uint8_t { kInWord, kBetween, kLineEnd };

constexpr auto kKinds = [] {
  std::array<Kind, 256> kinds{};
  for (const char c : {' ', '\t', '\v', '\f', '\0'}) kinds[static_cast<unsigned char>(c)] = Kind::kBetween;
  for (const char c : {'\n', '\r'}) kinds[static_cast<unsigned char>(c)] = Kind::kLineEnd;
  return kinds;
}();

Kind kindOf(char c) { return kKinds[static_cast<unsigned char>(c)]; }

char lowered(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string_view withoutPlus(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

bool isDigit(char c) { return c >= '0' && c <= '9'; }

std::string_view withoutComma(std::string_view word) {
  if (word.size() > 1 && word.ends_with(',')) word.remove_suffix(1);
  return word;
}

/// As a number of C's float is written: "1.5f".
std::string_view withoutSuffix(std::string_view word) {
  const auto endsNumber = [](char c) { return isDigit(c) || c == '.'; };
  if (word.size() > 1 && lowered(word.back()) == 'f' && endsNumber(word[word.size() - 2])) word.remove_suffix(1);
  return word;
}

/// "1,5", as some programs write it where people do; nothing where commas may separate numbers.
std::optional<double> withDecimalComma(std::string_view word) {
  const std::size_t comma = word.find(',');
  if (comma == word.npos || comma + 1 == word.size() || !isDigit(word[comma + 1])) return std::nullopt;
  if (word.find_first_of(".,", comma + 1) != word.npos || word.find('.') != word.npos) return std::nullopt;
  std::string point(word);
  point[comma] = '.';
  return asNumber(point);
}

/// What Microsoft's library once printed for NaN and infinity: "1.#QNAN", "-1.#IND00", "1.#INF".
std::optional<double> asOldWindowsNumber(std::string_view word) {
  const std::size_t hash = word.find(".#");
  if (hash == word.npos || !asNumber(word.substr(0, hash))) return std::nullopt;
  std::string_view name = word.substr(hash + 2);
  while (name.ends_with('0')) name.remove_suffix(1);
  if (isWord(name, "inf")) {
    return word.front() == '-' ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  }
  if (isWord(name, "ind") || isWord(name, "qnan") || isWord(name, "snan")) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return std::nullopt;
}

}  // namespace

bool TextScan::startsComment(std::size_t at) const {
  if (rest_[at] != '#' || comments_ != Comments::kHash) return false;
  if (at == 0 || rest_[at - 1] != '.' || at + 1 == rest_.size()) return true;
  const char next = lowered(rest_[at + 1]);
  return next != 'i' && next != 'q' && next != 's';
}

std::string_view TextScan::wordOfLine() {
  std::size_t begin = 0;
  while (begin < rest_.size() && kindOf(rest_[begin]) == Kind::kBetween) ++begin;
  std::size_t end = begin;
  while (end < rest_.size() && kindOf(rest_[end]) == Kind::kInWord && !startsComment(end)) ++end;
  const std::string_view word = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  if (word.empty() && !rest_.empty() && kindOf(rest_.front()) == Kind::kInWord) {  // a comment
    rest_.remove_prefix(std::min(rest_.find_first_of("\r\n"), rest_.size()));
  }
  return word;
}

std::string_view TextScan::word() {
  for (;;) {
    const std::string_view word = wordOfLine();
    if (!word.empty() || rest_.empty()) return word;
    skipLine();
  }
}

void TextScan::skipLine() {
  std::size_t end = 0;
  while (end < rest_.size() && kindOf(rest_[end]) != Kind::kLineEnd) ++end;
  if (end == rest_.size()) {
    rest_ = {};
    return;
  }
  rest_.remove_prefix(end + (rest_.substr(end).starts_with("\r\n") ? 2 : 1));
  ++line_;
}

bool isWord(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return lowered(a) == b; });
}

std::string inLowerCase(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(), lowered);
  return lower;
}

std::optional<double> asNumber(std::string_view word) {
  const std::string_view digits = withoutSuffix(withoutComma(withoutPlus(word)));
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size()) {
    const auto old = asOldWindowsNumber(word);
    return old ? old : withDecimalComma(digits);
  }
  if (error == std::errc::result_out_of_range)
    return std::strtod(std::string(digits).c_str(), nullptr);  // 0 or infinite
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> asInteger(std::string_view word) {
  word = withoutComma(withoutPlus(word));
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

tl::unexpected<Error> refusedAt(const TextScan& scan, const std::string& reason) {
  return refused("", "line " + std::to_string(scan.line()) + ": " + reason);
}

Result<Vec3> nextPoint(TextScan& scan, std::uint64_t vertex, bool acrossLines) {
  Vec3 point;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = acrossLines ? scan.word() : scan.wordOfLine();
    const auto value = asNumber(word);
    if (!value) {
      return refusedAt(
          scan, "vertex " + std::to_string(vertex) + " (from 0) has " +
                    (word.empty() ? "fewer than three coordinates" : inQuotes(word) + " where a number should be"));
    }
    point[axis] = *value;
  }
  return point;
}

bool endsWithinFace(std::string_view vertices, std::string_view rest, std::size_t wordsOfVertex,
                    std::size_t wordsAfter) {
  constexpr std::string_view kEnds = "\r\n";
  const auto wordsIn = [](std::string_view line) {
    TextScan scan(line, TextScan::Comments::kHash);
    std::size_t words = 0;
    while (!scan.wordOfLine().empty()) ++words;
    return words;
  };
  const std::size_t begin = vertices.find_last_of(kEnds) + 1;
  const std::string_view ofVertex = vertices.substr(begin);
  const std::size_t taken = wordsIn(ofVertex), left = wordsIn(rest.substr(0, rest.find_first_of(kEnds)));
  if (begin == 0 || taken == 0 || left == 0) return false;
  const auto corners = asInteger(TextScan(ofVertex).word());
  if (!corners || *corners < 3 || taken + left != static_cast<std::size_t>(*corners) + 1 + wordsAfter) return false;
  int others = 0;
  TextScan lines(vertices.substr(0, begin), TextScan::Comments::kHash);
  for (; lines.size() > 0 && others <= 1; lines.skipLine()) {
    std::size_t words = 0;
    while (!lines.wordOfLine().empty()) ++words;
    others += words != 0 && words != wordsOfVertex ? 1 : 0;
  }
  return others <= 1;
}

std::string inQuotes(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::size_t end = std::min(word.size(), kLongest);
  const auto continues = [&] { return end < word.size() && (static_cast<unsigned char>(word[end]) & 0xC0U) == 0x80U; };
  while (end + 3 > kLongest && continues()) --end;  // between two characters
  return '"' + printable(word.substr(0, end)) + (end < word.size() ? "...\"" : "\"");
}

}  // namespace haptics
