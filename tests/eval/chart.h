#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace haptics::eval {

inline constexpr int kChartFinestMesh = 12 * 289 * 289;  ///< Triangles, 1,002,252.

struct ChartOptions {
  std::uint64_t seed = 1;
  int finest = kChartFinestMesh;  ///< No meshes of more triangles; there are some up to 10 million.
  std::string method;             ///< Only this one; all of chartMethods() when empty.
  std::filesystem::path kept;     ///< worst.json of a hunt for the slowest tick: the worst is marked. Empty: none is.
  std::filesystem::path from;     ///< A chart.csv: drawn again, with `method` measured anew beside its own.
  std::filesystem::path out = ".";
};

/// The speed-accuracy chart: error in units of what a hand can notice, and force above 100 Hz that the surface does not
/// have, against the time of a contact tick (caches hot and cold) and its instructions; a curve for each method, a point
/// for each mesh resolution, the marker by the failure scenes and the limit cycle. Writes DIR/chart.csv, chart.png and chart.svg.
/// Throws std::runtime_error naming what cannot be read, written or drawn.
void runChart(const ChartOptions& options);

}  // namespace haptics::eval
