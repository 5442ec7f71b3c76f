#pragma once

#include <cstdint>
#include <filesystem>

namespace haptics::eval {

inline constexpr int kChartFinestMesh = 12 * 289 * 289;  ///< Triangles, 1,002,252.

/// The speed-accuracy chart: error in units of what a hand can notice, and force above 100 Hz that the surface does not
/// have, against the time of a contact tick (caches hot and cold) and its instructions; a curve for each method, a point
/// for each mesh resolution, the marker by the failure scenes. Writes DIR/chart.csv, chart.png and chart.svg.
/// @param finest  No meshes of more triangles than this; there are some up to 10 million.
/// Throws std::runtime_error naming what cannot be written or drawn.
void runChart(std::uint64_t seed, int finest, const std::filesystem::path& out);

}  // namespace haptics::eval
