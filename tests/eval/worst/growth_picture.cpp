#include "tests/eval/worst/growth_picture.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/figure/figure.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

constexpr double kPer = 1e5;  ///< Triangles.

}  // namespace

double Growth::exponent() const {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const Point& point : points) {
    const double u = std::log(point.ordinary_s), v = std::log(point.s);
    x += u;
    y += v;
    xx += u * u;
    xy += u * v;
  }
  const double n = static_cast<double>(points.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

double Growth::most_s() const {
  double most = 0;
  for (const Point& point : points) most = std::max(most, point.s / point.triangles * kPer);
  return most;
}

void drawGrowth(const std::vector<Growth>& all, double limit_s, const std::filesystem::path& folder) {
  Record files = Record::array();
  for (const Growth& growth : all) {
    Record points = Record::array();
    for (const Growth::Point& point : growth.points) points.push_back({point.triangles, point.s});
    files.push_back({{"name", growth.name}, {"exponent", growth.exponent()}, {"points", std::move(points)}});
  }
  drawFigure("worst_import", {{"files", std::move(files)}, {"limit_s", limit_s}}, folder / "worst_import");
}

}  // namespace haptics::eval
