#pragma once

#include <cstdint>
#include <filesystem>

namespace haptics::eval {

/// Every method in every failure scene: prints a table, writes DIR/failures.json.
/// @return Whether ours passed all and every baseline passed and failed where it is expected to.
[[nodiscard]] bool runFailures(std::uint64_t seed, const std::filesystem::path& out);

}  // namespace haptics::eval
