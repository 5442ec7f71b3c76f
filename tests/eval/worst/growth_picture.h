#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace haptics::eval {

/// Time that imports of one kind take.
struct Growth {
  struct Point {
    double triangles = 0;
    double s = 0;
    double ordinary_s = 0;  ///< Of a sphere of as many triangles, at the same moment.
  };
  std::string name;
  std::vector<Point> points;

  /// The slope of a line through the points, s over ordinary_s, both logarithmic.
  [[nodiscard]] double exponent() const;
  /// The most for 100,000 triangles.
  [[nodiscard]] double most_s() const;
};

/// Draws FOLDER/worst_import.png and worst_import.svg beside the limit of so many seconds for 100,000 triangles. Throws
/// std::runtime_error.
void drawGrowth(const std::vector<Growth>& all, double limit_s, const std::filesystem::path& folder);

}  // namespace haptics::eval
