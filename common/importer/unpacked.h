#pragma once

#include <string>

#include "common/error/error.h"

namespace haptics {

/// The file, or what it holds if it is a gzip file. Refused: damaged, cut off, of several parts, larger than kMaxFileSize, or
/// than its bytes can be thought to stand for.
[[nodiscard]] Result<std::string> unpacked(std::string file);

}  // namespace haptics
