#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace haptics::eval {

struct FailuresOptions {
  std::uint64_t seed = 1;
  int seeds = 1;       ///< How many, from `seed` on.
  std::string method;  ///< Only this one; all when empty.
  std::filesystem::path out = ".";
};

/// Every method in every failure scene: prints a table, writes DIR/failures.json. Throws std::invalid_argument when
/// there is no such method.
/// @return Whether ours passed all and every other method passed and failed where it is expected to, with each seed.
[[nodiscard]] bool runFailures(const FailuresOptions& options);

}  // namespace haptics::eval
