#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace haptics::eval {

/// What each correction of the contact core is for, drawn from the motion of a failure scene in which the core fails
/// without it: the same bodies and the same HIP, under the core without the correction and under the whole one.
/// Writes FOLDER/NAME.png for each ours_without_NAME, and for ours_NAME; for one of them only when `method` is its name.
/// Throws std::invalid_argument when there is no such method, std::runtime_error when a scene shows no failure.
void drawCorrections(std::uint64_t seed, std::string_view method, const std::filesystem::path& folder);

}  // namespace haptics::eval
