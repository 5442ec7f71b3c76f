#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "common/clock/monotonic.h"

// What runs of real processes look for in each other's files.
namespace haptics::stress {

inline constexpr std::chrono::milliseconds kLook{10};

inline std::filesystem::path self() { return std::filesystem::read_symlink("/proc/self/exe"); }

/// Throws std::runtime_error where it does not hold in time.
inline void waitUntil(double patience_s, const std::string& what, const std::function<bool()>& holds) {
  const std::uint64_t began_ns = monotonicNow_ns();
  while (!holds()) {
    if (1e-9 * static_cast<double>(monotonicNow_ns() - began_ns) > patience_s)
      throw std::runtime_error("not in time: " + what);
    std::this_thread::sleep_for(kLook);
  }
}

/// What follows the prefix, of the first line that begins with it.
inline std::optional<std::string> lineOf(const std::filesystem::path& file, const std::string& prefix) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(prefix)) return line.substr(prefix.size());
  }
  return std::nullopt;
}

/// Throws std::runtime_error where there is none.
inline nlohmann::ordered_json readJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  auto json = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!json.is_object()) throw std::runtime_error("no summary: " + file.string());
  return json;
}

}  // namespace haptics::stress
