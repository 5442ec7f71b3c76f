#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/eval/sweep/sweep.h"

namespace haptics::eval {

struct FailuresOptions {
  std::uint64_t seed = 1;
  int seeds = 1;                   ///< How many, from `seed` on.
  std::string method;              ///< Only this one; all when empty.
  std::string scene;               ///< Likewise.
  std::filesystem::path exportTo;  ///< A folder of each run goes here (exchange/README.md); empty: none.
  std::filesystem::path out = ".";
};

/// Every method in every failure scene. Its finish() prints a table, writes DIR/failures.json, and says whether ours passed
/// all and every other method passed and failed where it is expected to, with each seed. Throws std::invalid_argument when
/// there is no such method or scene.
[[nodiscard]] std::unique_ptr<Sweep> makeFailuresSweep(const FailuresOptions& options);

}  // namespace haptics::eval
