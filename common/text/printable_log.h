#pragma once

#include <spdlog/formatter.h>

#include <memory>
#include <string>

namespace haptics {

/// For a logger whose lines carry what other parties wrote: spdlog's pattern, with each message printable(), and so on
/// one line.
[[nodiscard]] std::unique_ptr<spdlog::formatter> printableLog(std::string pattern);

}  // namespace haptics
