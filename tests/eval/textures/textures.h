#pragma once

#include <cstdint>
#include <filesystem>

namespace haptics::eval {

struct TexturesOptions {
  std::uint64_t seed = 1;
  std::filesystem::path out = ".";
};

/// Section 4 of the paper, measured: every texture family, friction and force shading, open loop and with a device in the
/// loop. Prints tables, writes DIR/textures.json and the contact sheet DIR/textures.png.
/// @return Whether everything that has a limit is within it.
[[nodiscard]] bool runTextures(const TexturesOptions& options);

}  // namespace haptics::eval
