#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace haptics::eval {

/// Has eval_figures.py, which lies beside the program, draw STEM.png, and STEM.svg of curves. Throws std::runtime_error where it
/// does not; it has said why.
/// @param kind  One of its functions, which say what they take.
void drawFigure(const std::string& kind, const nlohmann::ordered_json& data, const std::filesystem::path& stem);

}  // namespace haptics::eval
