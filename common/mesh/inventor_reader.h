#pragma once

#include <filesystem>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Reads an Open Inventor file with Coin, in a process of its own: the program inventor_reader, which lies beside the
/// running one. Coin crashes on about one damaged file in a hundred (it does not check what a shape's indices name),
/// recurses as deep as the file nests and keeps global state; none of that may end or slow a server. The process is
/// spawned, not forked, so that the pages of a server with locked memory are not copied.
[[nodiscard]] Result<PolygonSoup> readInventor(const std::filesystem::path& file);

}  // namespace haptics
