#pragma once

#include "tests/eval/worst/worst.h"

namespace haptics::eval {

/// What an import may take: so long for 100,000 triangles, and time that grows with that of a sphere to this power. A busy
/// machine slows both.
inline constexpr double kWorstImport_s = 2;
inline constexpr double kWorstGrowth = 1.2;

/// Hunts for the slowest import: files of every family, changed towards more time of the processor for each triangle; the
/// worst of each then in sizes that double. Writes DIR/worst_import.json with their genes, and without `kept`
/// worst_import.png and .svg: time over triangles.
/// @param options  Of which `kept` is a worst_import.json; neither rate nor allowance counts.
/// @return Whether none took more than kWorstImport_s and kWorstGrowth.
/// Throws std::runtime_error naming what cannot be read, written or drawn; std::invalid_argument where there is no such
/// family.
[[nodiscard]] bool runWorstImport(const WorstOptions& options);

}  // namespace haptics::eval
