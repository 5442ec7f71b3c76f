#pragma once

#include <cstdint>
#include <filesystem>

namespace haptics::eval {

struct TeleoperationOptions {
  bool shortRun = false;  ///< Ours alone, without delay and with the longest; draws nothing.
  bool full = false;      ///< Ours besides with every device as the master, and ten lines each.
  std::uint64_t seed = 1;
  std::filesystem::path out = ".";
};

/// Couples a master and a follower over lines of every delay, to every remote contact, by every method. Writes teleoperation.json, and
/// unless it is short teleoperation.png and .svg.
/// @return Ours is passive, rests, and keeps packets back everywhere.
[[nodiscard]] bool runTeleoperation(const TeleoperationOptions& options);

}  // namespace haptics::eval
