#pragma once

#include <cstdio>
#include <string>

namespace haptics {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// From now on the log's lines go to `stream`, stdout or stderr, as "12:00:00.000 info text". Whatever a message holds, it is
/// one line: it may carry what other parties wrote.
void logTo(const std::FILE* stream);
/// From now on lines below `least` are left out.
void logFrom(LogLevel least);

void logAt(LogLevel level, const std::string& line);
inline void logInfo(const std::string& line) { logAt(LogLevel::kInfo, line); }
inline void logWarning(const std::string& line) { logAt(LogLevel::kWarning, line); }
inline void logError(const std::string& line) { logAt(LogLevel::kError, line); }

}  // namespace haptics
