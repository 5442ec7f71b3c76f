#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// Runs `program argument` with empty standard input and no other descriptors, and returns what it wrote to standard
/// output. Refused when it cannot be started, ends other than with exit code 0, takes longer than `patience` or writes
/// more than `mostOutput` bytes; then it is killed. Blocks the calling thread only. Thread-safe.
[[nodiscard]] Result<std::string> outputOf(const std::filesystem::path& program, const std::string& argument,
                                           std::chrono::milliseconds patience, std::size_t mostOutput);

}  // namespace haptics
