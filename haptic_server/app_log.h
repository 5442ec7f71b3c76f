#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace haptics {

inline void logInfo(const std::string& line) { spdlog::info("{}", line); }
inline void logWarning(const std::string& line) { spdlog::warn("{}", line); }

}  // namespace haptics
