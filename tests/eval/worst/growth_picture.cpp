#include "tests/eval/worst/growth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr std::array kColours{Colour{0.0, 0.447, 0.698}, Colour{0.835, 0.369, 0.0}, Colour{0.0, 0.62, 0.451},
                              Colour{0.8, 0.475, 0.655}, Colour{0.902, 0.624, 0.0}, Colour{0.337, 0.706, 0.914},
                              Colour{0.55, 0.57, 0.60},  Colour{0.60, 0.31, 0.64},  Colour{0.40, 0.26, 0.13},
                              Colour{0.69, 0.69, 0.10}};
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
  Figure figure;
  figure.title = "How long imports take where a hunter looks for the slowest";
  char limit[120];
  std::snprintf(limit, sizeof limit, "100,000 triangles may take %.3g s: dashed.", limit_s);
  figure.caption = {limit, "Time of the processor on this machine, with what else it did meanwhile."};
  figure.columns = 2;
  figure.legendTitle = "Files";
  std::vector<double> triangles, times_s;
  for (const Growth& growth : all) {
    for (const Growth::Point& point : growth.points) {
      triangles.push_back(point.triangles);
      times_s.push_back(point.s);
    }
  }
  const Decades x = decadesOf(triangles), y = decadesOf(times_s);
  const std::size_t half = (all.size() + 1) / 2;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i % half == 0) figure.panels.push_back({"worst of each kind", "triangles", "import, s", x, y, {}, {}});
    char exponent[40];
    std::snprintf(exponent, sizeof exponent, "grows with %.2f", all[i].exponent());
    figure.styles.push_back(
        {all[i].name, exponent, kColours[i % half % kColours.size()], i < half ? Marker::kDisc : Marker::kCross});
    Curve curve{i, {}};
    for (const Growth::Point& point : all[i].points) curve.points.push_back({point.triangles, point.s, ""});
    figure.panels.back().curves.push_back(std::move(curve));
  }
  figure.styles.push_back({"limit", "grows with 1", Colour{0.1, 0.1, 0.1}, Marker::kNone});
  for (Panel& panel : figure.panels) {
    const double least = std::pow(10, x.low), most = std::pow(10, x.high);
    panel.curves.push_back({all.size(), {{least, limit_s * least / kPer, ""}, {most, limit_s * most / kPer, ""}}});
  }
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figure, folder / "worst_import.png", folder / "worst_import.svg"));
}

}  // namespace haptics::eval
