#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/eval/methods.h"
#include "tests/eval/price.h"

namespace haptics::eval {

/// A method on meshes of about as many triangles: six shapes, 2 mm deep at 0.1 m/s.
struct ChartPoint {
  std::string_view method;
  int triangles;            ///< Asked for.
  double epsilon;           ///< Not exceeded in 99 % of a shape's ticks; of the worst shape.
  double above100Hz_rms_N;  ///< Force that the surface does not have; of the worst shape.
  Price price;              ///< Medians over the shapes; instructions on the sphere.
};

/// In order of triangles, then of methods().
[[nodiscard]] std::vector<ChartPoint> measureChartPoints(std::uint64_t seed, int finest);

/// Names of the failure scenes that a method fails.
[[nodiscard]] std::vector<std::string_view> failedScenes(const Method& method, std::uint64_t seed);

}  // namespace haptics::eval
