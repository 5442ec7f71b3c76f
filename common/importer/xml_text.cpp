#include "common/importer/xml_text.h"

namespace haptics {

int deepestNestingOf(std::string_view text) {
  int depth = 0, deepest = 0;
  eachTag(text, [&](const XmlTag& tag) {
    if (!tag.inside.ends_with('/')) depth += tag.ends ? -1 : 1;
    deepest = std::max(deepest, depth);
    return true;
  });
  return deepest;
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

}  // namespace haptics
