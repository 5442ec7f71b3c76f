#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace haptics {

/// Of elements, lists and nodes, of which Assimp reads each within another, by recursion. Real files nest below 100.
inline constexpr int kDeepestNesting = 1000;

/// A tag of an XML text: "<name ...>" or "</name>".
struct XmlTag {
  std::size_t at = 0;       ///< Of its name in the text.
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
      std::size_t name = at + (ends ? 2 : 1);
      std::size_t after = std::min(text.find_first_of(kEndsName, name), text.size());
      std::size_t end = after;
      for (char quote = 0; end < text.size() && (quote != 0 || text[end] != '>'); ++end) {
        if (quote != 0 ? text[end] == quote : text[end] == '"' || text[end] == '\'') quote = quote != 0 ? 0 : text[end];
      }
      if (const std::size_t colon = text.substr(name, after - name).rfind(':'); colon != text.npos) name += colon + 1;
      if (!take(XmlTag{name, text.substr(name, after - name), text.substr(after, end - after), ends})) return;
      at = end;
    }
  }
}

/// How many elements are within one another.
[[nodiscard]] int deepestNestingOf(std::string_view text);

/// What an attribute says in a tag's XmlTag::inside; empty: it is not there. A name such as ":path" has any prefix.
[[nodiscard]] std::string_view attributeIn(std::string_view inside, std::string_view name);

}  // namespace haptics
