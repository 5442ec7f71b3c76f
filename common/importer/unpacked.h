#pragma once

#include <string>

#include "common/error/error.h"

namespace haptics {

/// The file, or what it holds if it is a gzip file, of one part or of several (RFC 1952, 2.2). Refused: damaged, cut off, larger
/// than kMaxFileSize, or than its bytes can be thought to stand for.
[[nodiscard]] Result<std::string> unpacked(std::string file);

}  // namespace haptics
