#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/surface/cubic_spline.h"
#include "common/surface/spline_grid.h"

namespace haptics {
namespace {

constexpr double kSplineMargin = 0.005;  ///< Of the samples' range: how far a bound may lie outside what was found.
constexpr double kRounding = 1e-9;       ///< Of the largest sample: above what the spline's own evaluation rounds.
constexpr double kMaxCells = 262'144;    ///< That slope and curvature are looked at in: all of 512 * 512 samples.
constexpr int kDeepest = 8;              ///< Halvings of a cell; four are enough as a rule.

using Four = std::array<double, 4>;
using Net = std::array<Four, 4>;  ///< Control points of one cell: the cell's values lie between their extremes.

Four bezier(const Four& c) {
  return {(c[0] + 4 * c[1] + c[2]) / 6, (2 * c[1] + c[2]) / 3, (c[1] + 2 * c[2]) / 3, (c[1] + 4 * c[2] + c[3]) / 6};
}

Net transposed(const Net& net) {
  Net turned;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) turned[i][j] = net[j][i];
  }
  return turned;
}

Net bezier(const Net& net) {
  Net rows;
  for (int i = 0; i < 4; ++i) rows[i] = bezier(net[i]);
  rows = transposed(rows);
  for (Four& row : rows) row = bezier(row);
  return rows;
}

/// Control points of both halves of a curve (de Casteljau).
void halve(const Four& p, Four& first, Four& second) {
  const double a = (p[0] + p[1]) / 2, b = (p[1] + p[2]) / 2, c = (p[2] + p[3]) / 2;
  const double ab = (a + b) / 2, bc = (b + c) / 2, middle = (ab + bc) / 2;
  first = {p[0], a, ab, middle};
  second = {middle, bc, c, p[3]};
}

std::array<Net, 2> halves(const Net& net) {
  std::array<Net, 2> parts;
  for (int i = 0; i < 4; ++i) halve(net[i], parts[0][i], parts[1][i]);
  return parts;
}

double highestOf(const Net& net) {
  double highest = net[0][0];
  for (const Four& row : net) highest = std::max(highest, *std::max_element(row.begin(), row.end()));
  return highest;
}

/// The highest value of all cells, from above.
class Ceiling {
 public:
  Ceiling(double found, double slack) : found_(found), slack_(slack), bound_(found) {}

  [[nodiscard]] bool mayHold(double coefficient) const { return coefficient <= found_ + slack_; }
  void raiseTo(const Net& coefficients) { raise(bezier(coefficients), 0); }
  [[nodiscard]] double bound() const { return std::max(bound_, found_ + slack_); }

 private:
  double found_;  // reached by a cell's corner
  double slack_;
  double bound_;

  void raise(const Net& net, int depth) {
    found_ = std::max({found_, net[0][0], net[0][3], net[3][0], net[3][3]});
    const double highest = highestOf(net);
    if (highest <= found_ + slack_ || depth == kDeepest) {
      bound_ = std::max(bound_, highest);
      return;
    }
    for (const Net& half : halves(net)) {
      for (const Net& quarter : halves(transposed(half))) raise(quarter, depth + 1);
    }
  }
};

/// Slope and curvature at one place of a cell.
class Steepness {
 public:
  explicit Steepness(double t) : weights_(splineWeights(t)) {}

  void look(const Net& c) {
    const auto& [v, s, b] = weights_;
    const double x = product(c, s, v), y = product(c, v, s);
    const double xx = product(c, b, v), xy = product(c, s, s), yy = product(c, v, b);
    slope = std::max(slope, std::sqrt(x * x + y * y));
    const double half = (xx - yy) / 2;
    curvature = std::max(curvature, std::abs(xx + yy) / 2 + std::sqrt(half * half + xy * xy));
  }

  double slope = 0, curvature = 0;

 private:
  SplineWeights weights_;

  static double product(const Net& c, const Four& alongX, const Four& alongY) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      sum += alongY[i] * (c[i][0] * alongX[0] + c[i][1] * alongX[1] + c[i][2] * alongX[2] + c[i][3] * alongX[3]);
    }
    return sum;
  }
};

Net netAround(const SplineGrid& grid, std::size_t x, std::size_t y, double sign) {
  Net net;
  const float* row = grid.around(x, y);
  for (std::size_t i = 0; i < 4; ++i, row += grid.stride()) {
    for (std::size_t j = 0; j < 4; ++j) net[i][j] = sign * row[j];
  }
  return net;
}

/// Lowest and highest of a cell's coefficients: the cell's values lie between these too, though often by far.
std::pair<float, float> rangeAround(const SplineGrid& grid, std::size_t x, std::size_t y) {
  const float* row = grid.around(x, y);
  float low = *row, high = *row;
  for (std::size_t i = 0; i < 4; ++i, row += grid.stride()) {
    for (std::size_t j = 0; j < 4; ++j) {
      low = std::min(low, row[j]);
      high = std::max(high, row[j]);
    }
  }
  return {low, high};
}

}  // namespace

SplineBounds boundsOf(const SplineGrid& grid, std::span<const float> samples) {
  const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
  const double slack =
      kSplineMargin * (static_cast<double>(*most) - *least) + kRounding * std::max(std::abs(*most), std::abs(*least));
  Ceiling ceiling(*most, slack), floorUpsideDown(-*least, slack);
  Steepness corner(0), middle(0.5);
  const auto cells = static_cast<double>(samples.size());
  const auto stride = static_cast<std::size_t>(std::ceil(std::sqrt(cells / kMaxCells)));
  for (std::size_t y = 0; y < grid.height; ++y) {
    interruptionPoint();
    for (std::size_t x = 0; x < grid.width; ++x) {
      const auto [low, high] = rangeAround(grid, x, y);
      if (!ceiling.mayHold(high)) ceiling.raiseTo(netAround(grid, x, y, 1));
      if (!floorUpsideDown.mayHold(-low)) floorUpsideDown.raiseTo(netAround(grid, x, y, -1));
      if (x % stride != 0 || y % stride != 0) continue;
      const Net net = netAround(grid, x, y, 1);
      corner.look(net);
      middle.look(net);
    }
  }
  return {-floorUpsideDown.bound(), ceiling.bound(), std::max(corner.slope, middle.slope),
          std::max(corner.curvature, middle.curvature)};
}

}  // namespace haptics
