#pragma once

#include <filesystem>
#include <vector>

#include "tests/eval/textures/texture_figures.h"

namespace haptics::eval {

struct TexturesData {
  std::vector<TextureCase> textureCases;
  std::vector<TextureFigures> figures;  ///< Of each exhibit.
  std::vector<Record> laws, wrapped, resting, map, friction, shading;
};

/// Draws the contact sheet: each exhibit's relief, force and spectrum, what holds still, friction and shading. STEM.png.
void drawSheet(const TexturesData& data, std::uint64_t seed, const std::filesystem::path& stem);

}  // namespace haptics::eval
