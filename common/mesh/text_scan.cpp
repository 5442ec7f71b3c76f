#include "common/mesh/text_scan.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace haptics {
namespace {

constexpr std::string_view kWhiteSpace = " \t\n\r\v\f";

std::string_view withoutPlus(std::string_view word) {
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

}  // namespace

std::string_view nextLine(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  return line;
}

std::string_view nextWord(std::string_view& rest) {
  const std::size_t begin = rest.find_first_not_of(kWhiteSpace);
  rest.remove_prefix(begin == std::string_view::npos ? rest.size() : begin);
  const std::size_t end = std::min(rest.find_first_of(kWhiteSpace), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(end);
  return word;
}

std::optional<double> asNumber(std::string_view word) {
  word = withoutPlus(word);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);  // 0 or infinite
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> asInteger(std::string_view word) {
  word = withoutPlus(word);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

Result<float> coordinate(double value, std::uint64_t vertex) {
  if (!std::isfinite(value)) return refused("", "vertex " + std::to_string(vertex) + " (from 0) is not finite");
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    return refused("", "vertex " + std::to_string(vertex) + " (from 0) does not fit into float32");
  }
  return static_cast<float>(value);
}

Result<Vec3> nextPoint(std::string_view& rest, std::uint64_t vertex) {
  Vec3 point;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = nextWord(rest);
    const auto value = asNumber(word);
    if (!value) {
      return refused(
          "", "vertex " + std::to_string(vertex) + " (from 0) has " +
                  (word.empty() ? "fewer than three coordinates" : inQuotes(word) + " where a number should be"));
    }
    if (auto ok = coordinate(*value, vertex); !ok) return tl::unexpected(std::move(ok).error());
    // Rounded once: by way of a double, a number between two floats may come out as the other one.
    point[axis] = static_cast<double>(std::strtof(std::string(word).c_str(), nullptr));
  }
  return point;
}

std::string inQuotes(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "\"";
  for (const char c : word.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kLongest ? "...\"" : "\"");
}

}  // namespace haptics
