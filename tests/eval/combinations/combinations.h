#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace haptics::eval {

struct CombinationsOptions {
  std::uint64_t seed = 1;
  int seeds = 1;       ///< How many, from `seed` on.
  std::string method;  ///< In place of the production step; that when empty.
  std::string pair;    ///< Only this one, such as texture-softness; all when empty.
  std::string ablate;  ///< What is switched off, for the pairs that must then fail; nothing when empty.
  std::filesystem::path out = ".";
};

/// As --ablate names them.
[[nodiscard]] std::vector<std::string> ablationNames();

/// Every pair of surface features against its reference: prints a table, writes DIR/combinations.json and .csv and,
/// without an ablation, .png. Throws std::invalid_argument when there is no such pair or the ablation is not about it.
/// @return Whether every pair is within its limits with each seed; with an ablation, whether each
/// that it is about is beyond the limit of what it spoils; with a method true.
[[nodiscard]] bool runCombinations(const CombinationsOptions& options);

}  // namespace haptics::eval
