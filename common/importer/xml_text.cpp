#include "common/importer/xml_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/text/printable.h"

namespace haptics {
namespace {

/// Of an element, in a refusal.
constexpr std::size_t kLongestName = 40;

/// Of UTF-16; nothing: it is damaged.
std::optional<std::string> inUtf8(std::string_view text, bool isBigEndian) {
  if (text.size() % 2 != 0) return std::nullopt;
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(text[at]), second = static_cast<unsigned char>(text[at + 1]);
    return static_cast<std::uint32_t>(isBigEndian ? first << 8 | second : second << 8 | first);
  };
  constexpr std::uint32_t kHigh = 0xd800, kLow = 0xdc00, kAfter = 0xe000;
  std::string all;
  all.reserve(text.size() / 2);
  for (std::size_t at = 0; at < text.size(); at += 2) {
    std::uint32_t c = unit(at);
    if (c >= kHigh && c < kAfter) {
      at += 2;
      const std::uint32_t low = at < text.size() ? unit(at) : 0;
      if (c >= kLow || low < kLow || low >= kAfter) return std::nullopt;
      c = 0x10000 + ((c - kHigh) << 10) + (low - kLow);
    }
    const auto tail = [&](int shift) { all += static_cast<char>(0x80 | (c >> shift & 0x3f)); };
    if (c < 0x80) {
      all += static_cast<char>(c);
    } else if (c < 0x800) {
      all += static_cast<char>(0xc0 | c >> 6);
      tail(0);
    } else if (c < 0x10000) {
      all += static_cast<char>(0xe0 | c >> 12);
      tail(6), tail(0);
    } else {
      all += static_cast<char>(0xf0 | c >> 18);
      tail(12), tail(6), tail(0);
    }
  }
  return all;
}

/// Leaves `part` out, which begins at or after what was left out before it.
class InPlace {
 public:
  explicit InPlace(std::string& text) : text_(text) {}
  void leaveOut(std::size_t at, std::size_t size) {
    if (at < from_) return;
    keepTo(at);
    from_ = at + size;
  }
  void end() {
    keepTo(text_.size());
    text_.resize(to_);
  }

 private:
  std::string& text_;
  std::size_t from_ = 0, to_ = 0;

  void keepTo(std::size_t at) {
    if (to_ != from_) std::copy(text_.begin() + from_, text_.begin() + at, text_.begin() + to_);
    to_ += at - from_;
  }
};

/// And instructions, but the declaration.
void withoutComments(std::string& text) {
  InPlace kept(text);
  for (std::size_t at = 0; (at = text.find('<', at)) != text.npos;) {
    const std::string_view rest = std::string_view(text).substr(at);
    const bool isInstruction = rest.starts_with("<?") && !rest.starts_with("<?xml ");
    if (!rest.starts_with("<!") && !isInstruction) {
      ++at;
      continue;
    }
    const bool isComment = isInstruction || rest.starts_with("<!--");
    const std::string_view ending = isInstruction                   ? "?>"
                                    : isComment                     ? "-->"
                                    : rest.starts_with("<![CDATA[") ? "]]>"
                                                                    : ">";
    const std::size_t found = text.find(ending, at + (isComment && !isInstruction ? 4 : 2));
    const std::size_t end = found == text.npos ? text.size() : found + ending.size();
    if (isComment) kept.leaveOut(at, end - at);
    at = end;
  }
  kept.end();
}

/// A blank, digit or letter that is written as its number ("&#10;") as it is, and CDATA as other text.
void withoutSpellings(std::string& text) {
  constexpr std::string_view kData = "<![CDATA[", kDataEnd = "]]>";
  if (text.find("&#") == text.npos && text.find(kData) == text.npos) return;
  const auto isPlain = [](std::uint32_t c) {
    constexpr std::string_view kMeansMore = "<>&\"'";
    return c == '\t' || c == '\n' || c == '\r' ||
           (c >= ' ' && c <= '~' && kMeansMore.find(static_cast<char>(c)) == kMeansMore.npos);
  };
  std::string plain;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t next = std::min(text.find_first_of("&<", at), text.size());
    plain.append(text, at, next - at);
    at = next;
    const std::string_view rest = std::string_view(text).substr(at);
    if (rest.starts_with("&#")) {
      const bool isHex = rest.substr(2).starts_with('x');
      std::uint32_t code = 0;
      const auto [end, error] =
          std::from_chars(rest.data() + (isHex ? 3 : 2), rest.data() + rest.size(), code, isHex ? 16 : 10);
      if (error == std::errc() && end != rest.data() + rest.size() && *end == ';' && isPlain(code)) {
        plain += static_cast<char>(code);
        at += static_cast<std::size_t>(end - rest.data()) + 1;
        continue;
      }
    } else if (const std::size_t end = rest.find(kDataEnd); rest.starts_with(kData) && end != rest.npos) {
      for (const char c : rest.substr(kData.size(), end - kData.size())) {
        plain += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
      }
      at += end + kDataEnd.size();
      continue;
    }
    if (!rest.empty()) plain += text[at++];
  }
  text = std::move(plain);
}

void withoutFirstPrefix(std::string& text) {
  const auto prefixOf = [&](const XmlTag& tag) {
    const std::size_t from = tag.begin + (tag.ends ? 2 : 1);
    return std::string_view(text).substr(from, tag.at - from);
  };
  std::string prefix;
  std::vector<std::size_t> places;
  eachTag(text, [&](const XmlTag& tag) {
    const std::string_view own = prefixOf(tag);
    if (prefix.empty()) prefix = own;
    if (own == prefix) places.push_back(tag.at - own.size());
    return !prefix.empty();
  });
  if (prefix.empty()) return;
  InPlace kept(text);
  for (const std::size_t at : places) kept.leaveOut(at, prefix.size());
  kept.end();
}

}  // namespace

Result<std::string> plainXml(std::string text) {
  const std::string_view head = std::string_view(text).substr(0, 2);
  const bool isMarked = head == "\xff\xfe" || head == "\xfe\xff";
  if (isMarked || head == std::string_view("<\0", 2) || head == std::string_view("\0<", 2)) {
    const bool isBigEndian = head == "\xfe\xff" || head == std::string_view("\0<", 2);
    auto converted = inUtf8(std::string_view(text).substr(isMarked ? 2 : 0), isBigEndian);
    if (!converted) return refused("", "is UTF-16 that is cut off or damaged; save it in UTF-8");
    text = *std::move(converted);
  }
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  withoutComments(text);
  withoutSpellings(text);
  withoutFirstPrefix(text);
  return text;
}

Result<void> checkNesting(std::string_view text, std::string_view root) {
  const auto tagOf = [](std::string_view name, bool ends = false) {
    return (ends ? "</" : "<") + printable(name.substr(0, kLongestName)) + '>';
  };
  std::vector<std::string_view> open;
  std::string fault;
  bool hasBegun = false;
  eachTag(text, [&](const XmlTag& tag) {
    if (!hasBegun && tag.name != root)
      fault = "begins with " + tagOf(tag.name, tag.ends) + "; its first element has to be " + tagOf(root);
    hasBegun = true;
    if (tag.ends && !open.empty() && open.back() != tag.name)
      fault = "is damaged: " + tagOf(open.back()) + " ends with " + tagOf(tag.name, true);
    if (tag.ends && open.empty() && fault.empty()) fault = "is damaged: " + tagOf(tag.name, true) + " ends nothing";
    if (!fault.empty()) return false;
    if (tag.ends) {
      open.pop_back();
    } else if (!tag.inside.ends_with('/')) {
      open.push_back(tag.name);
      if (open.size() > kDeepestNesting) fault = "nests more than " + std::to_string(kDeepestNesting) + " levels deep";
    }
    return fault.empty();
  });
  if (!hasBegun) fault = "is no XML: it has no element; its first has to be " + tagOf(root);
  if (fault.empty() && !open.empty()) fault = "is cut off: " + tagOf(open.back()) + " does not end";
  if (fault.empty()) return {};
  return refused("", fault);
}

std::string_view XmlRewriting::whole(const XmlTag& tag) const {
  const auto end = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - text_.data());
  return text_.substr(tag.begin, end + 1 - tag.begin);
}

std::string_view XmlRewriting::element(const XmlTag& begin) const {
  if (begin.inside.ends_with('/')) return whole(begin);
  const std::string_view rest = text_.substr(begin.begin);
  std::size_t size = rest.size();
  int depth = 0;
  eachTag(rest, [&](const XmlTag& tag) {
    if (!tag.inside.ends_with('/')) depth += tag.ends ? -1 : 1;
    if (depth == 0) size = static_cast<std::size_t>(tag.inside.data() + tag.inside.size() - rest.data()) + 1;
    return depth > 0;
  });
  return rest.substr(0, size);
}

void XmlRewriting::replace(std::string_view part, std::string_view by) {
  const auto at = static_cast<std::size_t>(part.data() - text_.data());
  written_.append(text_.substr(taken_, at - taken_)).append(by);
  taken_ = at + part.size();
}

void XmlRewriting::insertAfter(const XmlTag& tag, std::string_view added) {
  const std::string_view all = whole(tag);
  replace(all.substr(all.size()), added);
}

std::vector<std::string_view> wordsIn(std::string_view text) {
  std::vector<std::string_view> words;
  eachWord(text, [&](std::string_view word) { words.push_back(word); });
  return words;
}

std::optional<std::string> ofUnitAxis(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : wordsIn(text)) {
    const auto number = numberOf<double>(word);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.size() != 4) return std::nullopt;
  const double length = std::hypot(numbers[0], numbers[1], numbers[2]);
  if (length == 0 && numbers[3] != 0) return std::nullopt;
  if (length == 0) return "0 0 1 0";
  constexpr double kOfRounding = 1e-6;  // stays as it is
  if (std::abs(length - 1) < kOfRounding) return std::string(text);
  std::string unit;
  for (int axis = 0; axis < 3; ++axis) {
    char word[32];
    unit.append(word, std::to_chars(word, word + sizeof word, numbers[axis] / length).ptr).append(1, ' ');
  }
  return unit.append(wordsIn(text)[3]);
}

std::string_view attributeIn(std::string_view inside, std::string_view name) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::size_t at = 0;
  for (;;) {
    const std::size_t from = inside.find_first_not_of(" \t\r\n/", at);
    const std::size_t is = inside.find('=', from);
    const std::size_t quote = is == inside.npos ? is : inside.find_first_not_of(kBlanks, is + 1);
    if (quote == inside.npos || (inside[quote] != '"' && inside[quote] != '\'')) return {};
    const std::size_t end = inside.find(inside[quote], quote + 1);
    if (end == inside.npos) return {};
    const std::string_view spaced = inside.substr(from, is - from);
    const std::string_view own = spaced.substr(0, spaced.find_last_not_of(kBlanks) + 1);
    if (own == name || (name.starts_with(':') && own.ends_with(name))) return inside.substr(quote + 1, end - quote - 1);
    at = end + 1;
  }
}

std::string withoutEntities(std::string_view attribute) {
  std::string text(attribute);
  for (const auto& [entity, letter] :
       {std::pair{"&quot;", "\""}, {"&apos;", "'"}, {"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}}) {
    for (std::size_t at = 0; (at = text.find(entity, at)) != text.npos; ++at)
      text.replace(at, std::string_view(entity).size(), letter);
  }
  return text;
}

}  // namespace haptics
