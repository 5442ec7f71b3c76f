#pragma once

#include <vtkContextItem.h>

#include <filesystem>
#include <string>

#include "common/error/error.h"

namespace haptics::eval {

/// Paints the item on white, one unit to the pixel, into both files; no SVG where its name is empty. Refused: a file that
/// cannot be written.
[[nodiscard]] Result<void> drawItem(vtkContextItem& item, int width_px, int height_px, const std::string& title,
                                    const std::filesystem::path& png, const std::filesystem::path& svg);

}  // namespace haptics::eval
