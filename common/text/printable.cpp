#include "common/text/printable.h"

#include <cstdio>
#include <span>

namespace haptics {
namespace {

bool isSafe(char32_t code) {
  struct Range {
    char32_t first, last;
  };
  constexpr Range kUnsafe[] = {{0, 0x1f},        {0x7f, 0x9f},     {0x61c, 0x61c},
                               {0x200e, 0x200f}, {0x2028, 0x202e}, {0x2066, 0x2069}};
  for (const Range& range : kUnsafe) {
    if (code >= range.first && code <= range.last) return false;
  }
  return true;
}

void appendEscaped(std::string& out, char32_t code) {
  char text[16];
  std::snprintf(text, sizeof text, code <= 0xff ? "\\x%02x" : "\\u%04x", static_cast<unsigned>(code));
  out += text;
}

/// @param keepsAll  Of what is UTF-8.
std::string escaped(std::string_view text, bool keepsAll) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Utf8Character character = firstCharacterOf(text);
    const std::size_t bytes = character.bytes == 0 ? 1 : character.bytes;
    if (character.bytes == 0) {
      appendEscaped(out, static_cast<unsigned char>(text[0]));
    } else if (keepsAll || isSafe(character.code)) {
      out += text.substr(0, bytes);
    } else {
      appendEscaped(out, character.code);
    }
    text.remove_prefix(bytes);
  }
  return out;
}

}  // namespace

Utf8Character firstCharacterOf(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  struct Form {
    unsigned char mask, lead;
    char32_t least;  // a shorter form exists below
  };
  constexpr Form kForms[] = {{0x80, 0x00, 0}, {0xe0, 0xc0, 0x80}, {0xf0, 0xe0, 0x800}, {0xf8, 0xf0, 0x10000}};
  for (std::size_t more = 0; more < std::size(kForms); ++more) {
    const Form& form = kForms[more];
    if ((byte(0) & form.mask) != form.lead || text.size() <= more) continue;
    char32_t code = byte(0) & static_cast<unsigned char>(~form.mask);
    for (std::size_t i = 1; i <= more; ++i) {
      if ((byte(i) & 0xc0U) != 0x80) return {};
      code = code << 6 | (byte(i) & 0x3fU);
    }
    const bool isSurrogate = code >= 0xd800 && code <= 0xdfff;
    if (code < form.least || code > 0x10ffff || isSurrogate) return {};
    return {code, more + 1};
  }
  return {};
}

std::string printable(std::string_view text) { return escaped(text, false); }

std::string asUtf8(std::string_view text) { return escaped(text, true); }

}  // namespace haptics
