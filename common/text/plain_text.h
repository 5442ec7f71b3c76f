#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/error/error.h"

namespace haptics {

/// The text without a UTF-8 byte order mark at its beginning, which editors put there.
[[nodiscard]] std::string_view withoutByteOrderMark(std::string_view text);

/// What a text file says: without a byte order mark, and without the NUL and control-Z characters that some programs fill
/// its end with. Refused, naming it: another encoding than one of bytes, which is UTF-16 or UTF-32.
[[nodiscard]] Result<std::string_view> plainText(std::string_view file);

/// The same, with a line feed at the end of each line, which may be a carriage return or both in the file.
[[nodiscard]] Result<std::string> plainLines(std::string_view file);

/// The same of the file at `path`. Refused by its name, beside that: what is no regular file, which is not opened; more bytes
/// than `most`.
[[nodiscard]] Result<std::string> plainLinesOf(const std::filesystem::path& path, std::uintmax_t most);

}  // namespace haptics
