#include "common/text/plain_text.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

namespace haptics {
namespace {

using namespace std::string_view_literals;

/// Whether the first characters of a file are ASCII in so many bytes each, of which the one at `letter` is not zero.
bool beginsWithWide(std::string_view file, std::size_t bytes, std::size_t letter) {
  constexpr std::size_t kLookedAt = 16;
  if (file.size() < kLookedAt) file = file.substr(0, file.size() - file.size() % bytes);
  for (std::size_t i = 0; i < std::min(file.size(), kLookedAt); ++i) {
    const bool isText = (file[i] >= ' ' && file[i] <= '~') || (file[i] >= '\t' && file[i] <= '\r');
    if (i % bytes == letter ? !isText : file[i] != '\0') return false;
  }
  return !file.empty();
}

/// By its byte order mark or, without one, by the zeros beside its first characters; empty if neither is there.
std::string_view wideEncodingOf(std::string_view file) {
  if (file.starts_with("\xff\xfe\0\0"sv) || file.starts_with("\0\0\xfe\xff"sv)) return "UTF-32";
  if (file.starts_with("\xff\xfe"sv) || file.starts_with("\xfe\xff"sv)) return "UTF-16";
  if (beginsWithWide(file, 2, 0) || beginsWithWide(file, 2, 1)) return "UTF-16";
  return beginsWithWide(file, 4, 0) || beginsWithWide(file, 4, 3) ? "UTF-32" : "";
}

}  // namespace

std::string_view withoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

Result<std::string_view> plainText(std::string_view file) {
  if (const auto encoding = wideEncodingOf(file); !encoding.empty()) {
    return refused("", "is in " + std::string(encoding) + "; save it in UTF-8");
  }
  const std::size_t last = file.find_last_not_of("\0\x1a"sv);
  return withoutByteOrderMark(file.substr(0, last == file.npos ? 0 : last + 1));
}

Result<std::string> plainLines(std::string_view file) {
  return plainText(file).map([](std::string_view text) {
    std::string lines;
    lines.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\r' && text.substr(i + 1).starts_with('\n')) continue;
      lines += text[i] == '\r' ? '\n' : text[i];
    }
    return lines;
  });
}

Result<std::string> plainLinesOf(const std::filesystem::path& path, std::uintmax_t most) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return refused(path.string(), error.message());
  if (size > most)
    return refused(path.string(),
                   "has " + std::to_string(size) + " bytes; at most " + std::to_string(most) + " are taken");
  std::ifstream in(path, std::ios::binary);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) return refused(path.string(), "cannot be read");
  return plainLines(text).map_error([&](Error bad) { return Error{path.string(), std::move(bad.reason)}; });
}

}  // namespace haptics
