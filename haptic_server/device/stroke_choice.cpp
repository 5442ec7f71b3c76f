#include "haptic_server/device/stroke_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/interruption/interruption.h"
#include "common/maths/elementary.h"
#include "haptic_server/device/exploration_plan.h"

namespace haptics {
namespace {

/// Columns looked at along the longer side of the box. More find smaller places; the cost grows with the square.
constexpr int kColumns = 40;
/// Cosine of the steepest slope to stroke, 50 degrees: beyond it a hand pressing down slides off sideways.
constexpr double kSmallestUp = 0.6428;
/// Height step between neighbouring points, in units of their distance, that is an edge and not a slope of the surface.
constexpr double kEdgeStep = 2;
/// Metres between the points of a stroke; the longest stroke.
constexpr double kSpacing = 0.002;
constexpr double kLongestStroke = 0.05;
/// Points of a stroke on an object so small that kSpacing would leave fewer, if its columns give as many.
constexpr std::size_t kFewestPoints = 8;
static_assert(kLongestStroke / kSpacing + 1 <= kMaxStrokePoints && kFewestPoints <= kMaxStrokePoints);
/// Metres to stay away from edges, more than the hand strays; and its largest share of the box's shorter side, for
/// small objects. Given up in steps where there is no such place.
constexpr double kEdgeMargin = 0.006;
constexpr double kEdgeMarginShare = 0.1;
constexpr double kMarginPrice = 1.5;
constexpr int kFewestColumns = 3;  // columns that a stroke may cross, however coarse they are
/// How much less a stroke at the box's rim counts than one at its middle. Breaks ties on flat tops.
constexpr double kRimDiscount = 0.2;

bool continues(const TopPoint& a, const TopPoint& b) {
  const Vec3 step = b.position - a.position;
  return std::abs(step.z) <= kEdgeStep * elementary::hypot(step.x, step.y);
}

std::optional<TopPoint> gentle(const TopView& view, double x, double y) {
  auto point = view(x, y);
  if (point && point->normal.z < kSmallestUp) point.reset();
  return point;
}

/// The upper side on a square grid of columns.
class Relief {
 public:
  Relief(const TopView& view, Vec3 low, Vec3 high) : middle_((low + high) / 2.0), extent_(high - low) {
    const double cell = std::max(extent_.x, extent_.y) / kColumns;
    if (!(cell > 0)) return;
    cell_ = cell;
    size_ = {columnsIn(extent_.x), columnsIn(extent_.y)};
    points_.reserve(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]));
    for (int j = 0; j < size_[1]; ++j) {
      interruptionPoint();
      for (int i = 0; i < size_[0]; ++i) {
        points_.push_back(gentle(view, centreOf(0, i), centreOf(1, j)));
      }
    }
  }

  [[nodiscard]] double cell() const { return cell_; }
  [[nodiscard]] int size(int axis) const { return size_[axis]; }
  [[nodiscard]] double shorterSide() const { return std::min(extent_.x, extent_.y); }

  [[nodiscard]] const std::optional<TopPoint>& at(int i, int j) const {
    static const std::optional<TopPoint> kOutside;
    if (i < 0 || j < 0 || i >= size_[0] || j >= size_[1]) return kOutside;
    return points_[static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(i)];
  }

  /// Gentle all around, `margin` columns far.
  [[nodiscard]] bool isInside(int i, int j, int margin) const {
    for (int dj = -margin; dj <= margin; ++dj) {
      for (int di = -margin; di <= margin; ++di) {
        if (!at(i + di, j + dj)) return false;
      }
    }
    return true;
  }

  /// 1 at the middle of the box, 1 - kRimDiscount at its corners.
  [[nodiscard]] double centrality(double x, double y) const {
    const double away = elementary::hypot(x - middle_.x, y - middle_.y);
    return 1 - kRimDiscount * away / (elementary::hypot(extent_.x, extent_.y) / 2);
  }

 private:
  [[nodiscard]] int columnsIn(double length) const {
    return std::max(1, static_cast<int>(std::floor(length / cell_ + 0.5)));
  }
  [[nodiscard]] double centreOf(int axis, int column) const {
    return middle_[axis] + (column + 0.5 - 0.5 * size_[axis]) * cell_;
  }

  Vec3 middle_;
  Vec3 extent_;
  double cell_ = 0;
  std::array<int, 2> size_{0, 0};
  std::vector<std::optional<TopPoint>> points_;
};

struct Window {
  std::vector<TopPoint> points;  // of neighbouring columns
  double score = 0;
};

/// The best part of a run of neighbouring columns that is at most kLongestStroke long, if it is better than `best`.
void consider(const Relief& relief, std::span<const TopPoint> run, Window& best) {
  if (run.empty()) return;
  const auto longest = static_cast<std::size_t>(std::max<double>(kFewestColumns, kLongestStroke / relief.cell() + 1));
  const std::size_t width = std::min(run.size(), longest);
  for (std::size_t first = 0; first + width <= run.size(); ++first) {
    const auto window = run.subspan(first, width);
    double up = 0;  // summed: longer and gentler is better
    for (const TopPoint& p : window) up += p.normal.z;
    const Vec3 middle = (window.front().position + window.back().position) / 2.0;
    const double score = up * relief.centrality(middle.x, middle.y);
    if (score > best.score) best = {{window.begin(), window.end()}, score};
  }
}

Window bestWindow(const Relief& relief, int margin) {
  Window best;
  std::vector<TopPoint> run;
  for (const int along : {0, 1}) {
    for (int row = 0; row < relief.size(1 - along); ++row) {
      for (int column = 0; column <= relief.size(along); ++column) {  // the one outside ends the run
        const int i = along == 0 ? column : row;
        const int j = along == 0 ? row : column;
        const bool inside = relief.isInside(i, j, margin);
        if (!run.empty() && !(inside && continues(run.back(), *relief.at(i, j)))) {
          consider(relief, run, best);
          run.clear();
        }
        if (inside) run.push_back(*relief.at(i, j));
      }
    }
  }
  return best;
}

/// Looks again, at kSpacing, between the ends of a window: the longest unbroken part.
std::vector<Vec3> resample(const TopView& view, const Window& window) {
  const Vec3 from = window.points.front().position;
  const Vec3 end = window.points.back().position;
  const double whole = elementary::hypot(end.x - from.x, end.y - from.y);
  const double length = std::min(whole, kLongestStroke);  // columns of a large object are coarse
  const Vec3 to = whole > 0 ? glm::mix(from, end, length / whole) : end;
  const auto steps = static_cast<std::size_t>(std::floor(length / kSpacing));
  const std::size_t count = std::max(steps + 1, std::min(window.points.size(), kFewestPoints));

  std::vector<TopPoint> run, longest;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
    const auto point = gentle(view, std::lerp(from.x, to.x, s), std::lerp(from.y, to.y, s));
    if (!point || (!run.empty() && !continues(run.back(), *point))) run.clear();
    if (point) run.push_back(*point);
    if (run.size() > longest.size()) longest = run;
  }
  std::vector<Vec3> points;
  points.reserve(longest.size());
  for (const TopPoint& p : longest) points.push_back(p.position);
  return points;
}

}  // namespace

std::vector<Vec3> chooseStroke(const TopView& view, Vec3 low, Vec3 high) {
  const Relief relief(view, low, high);
  if (relief.cell() == 0) return {};
  const double margin_m = std::min(kEdgeMargin, kEdgeMarginShare * relief.shorterSide());
  int margin = static_cast<int>(std::ceil(margin_m / relief.cell()));
  Window best = bestWindow(relief, margin);
  while (margin > 0) {
    margin /= 2;
    Window bolder = bestWindow(relief, margin);
    if (bolder.score >= kMarginPrice * best.score) best = std::move(bolder);
  }
  return best.points.empty() ? std::vector<Vec3>{} : resample(view, best);
}

}  // namespace haptics
