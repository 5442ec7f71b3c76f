#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// Of elements, lists and nodes, of which Assimp reads each within another, by recursion. Real files nest below 100.
inline constexpr int kDeepestNesting = 1000;

/// A tag of an XML text: "<name ...>" or "</name>".
struct XmlTag {
  std::size_t begin = 0;    ///< Of its '<' in the text.
  std::size_t at = 0;       ///< Of its name, after a prefix.
  std::string_view name;    ///< Without a prefix of a namespace.
  std::string_view inside;  ///< After the name, up to the end of the tag.
  bool ends = false;        ///< "</name>".
};

/// Calls `take` for each tag in the text's order, until it returns false; comments, CDATA, declarations and instructions are
/// passed over. Looks at no more than that: a text that is no XML has some tags or none.
template <class Take>
void eachTag(std::string_view text, const Take& take) {
  constexpr std::string_view kEndsName = " \t\r\n/>";
  for (std::size_t at = text.find('<'); at != text.npos && at + 1 < text.size(); at = text.find('<', at)) {
    const auto skipTo = [&](std::string_view end) {
      const std::size_t found = text.find(end, at);
      at = found == text.npos ? text.size() : found + end.size();
    };
    if (text.substr(at).starts_with("<!--")) {
      skipTo("-->");
    } else if (text.substr(at).starts_with("<![CDATA[")) {
      skipTo("]]>");
    } else if (text[at + 1] == '!' || text[at + 1] == '?') {
      skipTo(">");
    } else {
      const bool ends = text[at + 1] == '/';
      const std::size_t begin = at;
      std::size_t name = at + (ends ? 2 : 1);
      std::size_t after = std::min(text.find_first_of(kEndsName, name), text.size());
      std::size_t end = after;
      for (char quote = 0; end < text.size() && (quote != 0 || text[end] != '>'); ++end) {
        if (quote != 0 ? text[end] == quote : text[end] == '"' || text[end] == '\'') quote = quote != 0 ? 0 : text[end];
      }
      if (const std::size_t colon = text.substr(name, after - name).rfind(':'); colon != text.npos) name += colon + 1;
      if (!take(XmlTag{begin, name, text.substr(name, after - name), text.substr(after, end - after), ends})) return;
      at = end;
    }
  }
}

/// The text in UTF-8, as one of Assimp's readers takes it: without a byte order mark, comments, CDATA, numbers in place of blanks
/// ("&#10;"), and the prefix that its first element has, if any, of each element that has the same. Refused: UTF-16 that is cut off or damaged.
[[nodiscard]] Result<std::string> plainXml(std::string text);

/// Refused: elements that nest deeper than kDeepestNesting, that do not end, or that end within others; a first one of another
/// name. @param root  Its name.
[[nodiscard]] Result<void> checkNesting(std::string_view text, std::string_view root);

/// A text part of which is written anew, in the text's order.
class XmlRewriting {
 public:
  explicit XmlRewriting(std::string_view text) : text_(text) {}

  [[nodiscard]] std::string_view text() const { return text_; }
  /// From its '<' to the end of the tag that ends it.
  [[nodiscard]] std::string_view element(const XmlTag& begin) const;
  /// From its '<' to its '>'.
  [[nodiscard]] std::string_view whole(const XmlTag& tag) const;
  void replace(std::string_view part, std::string_view by);
  void insertBefore(const XmlTag& tag, std::string_view added) { replace(whole(tag).substr(0, 0), added); }
  void insertAfter(const XmlTag& tag, std::string_view added);
  void replaceElement(const XmlTag& begin, std::string_view by) { replace(element(begin), by); }
  /// Whether the tag is in what has been replaced.
  [[nodiscard]] bool isReplaced(const XmlTag& tag) const { return tag.at < taken_; }
  [[nodiscard]] std::string end() { return std::move(written_.append(text_.substr(taken_))); }

 private:
  std::string_view text_;
  std::string written_;
  std::size_t taken_ = 0;
};

template <std::size_t N>
[[nodiscard]] bool isOneOf(const std::string_view (&those)[N], std::string_view name) {
  return std::find(std::begin(those), std::end(those), name) != std::end(those);
}

/// Calls `take` for each word between blanks and commas.
template <class Take>
void eachWord(std::string_view text, const Take& take) {
  constexpr std::string_view kBetween = " ,\t\r\n";
  for (std::size_t at = 0; (at = text.find_first_not_of(kBetween, at)) != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
    take(text.substr(at, end - at));
    at = end;
  }
}

/// All of eachWord().
[[nodiscard]] std::vector<std::string_view> wordsIn(std::string_view text);

template <class T>
std::optional<T> numberOf(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// An axis and an angle, with an axis of length 1; one that has no length turns by nothing. Nothing: these are no four numbers,
/// or an axis without a length and an angle.
[[nodiscard]] std::optional<std::string> ofUnitAxis(std::string_view text);

/// What an attribute says in a tag's XmlTag::inside; empty: it is not there. A name such as ":path" has any prefix.
[[nodiscard]] std::string_view attributeIn(std::string_view inside, std::string_view name);

/// What an attribute means, of which "&quot;" and the like stand for characters.
[[nodiscard]] std::string withoutEntities(std::string_view attribute);

/// Whether an attribute is "false", which some write as VRML does, in capitals.
[[nodiscard]] inline bool isFalse(std::string_view inside, std::string_view name) {
  const std::string_view word = attributeIn(inside, name);
  return word == "false" || word == "FALSE";
}

}  // namespace haptics
