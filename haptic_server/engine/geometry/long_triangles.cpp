#include "haptic_server/engine/geometry/long_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/interruption/grow.h"
#include "haptic_server/engine/geometry/float_box.h"

namespace haptics {
namespace {

/// Times as long as nearly all others: such triangles say nothing of how large a mesh is.
constexpr float kGiant = 4;
/// Above 0, for triangles that a deformation has brought to one place.
constexpr double kFinest_m = std::numeric_limits<float>::min();

struct Bounds {
  Vec3 low{std::numeric_limits<double>::infinity()};
  Vec3 high{-std::numeric_limits<double>::infinity()};

  void grow(const Corners& corners) {
    for (const Vec3 corner : corners) {
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  }
  [[nodiscard]] Vec3 size() const { return high - low; }
  [[nodiscard]] double longest() const {
    const Vec3 s = size();
    return std::max({s.x, s.y, s.z});
  }
  [[nodiscard]] double volume() const {
    const Vec3 s = size();
    return s.x * s.y * s.z;
  }
};

Bounds boundsOf(const Corners& corners) {
  Bounds bounds;
  bounds.grow(corners);
  return bounds;
}

/// Cubes.
class Grid {
 public:
  using Place = std::array<std::int32_t, 3>;

  Grid(const Bounds& bounds, int along) : low_(bounds.low), cell_m_(std::max(bounds.longest() / along, kFinest_m)) {
    const Vec3 size = bounds.size();
    for (int d = 0; d < 3; ++d) {
      count_[static_cast<std::size_t>(d)] =
          static_cast<std::int32_t>(std::clamp<double>(std::ceil(size[d] / cell_m_), 1, along));
    }
  }
  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
           static_cast<std::size_t>(count_[2]);
  }
  [[nodiscard]] Vec3 lowOf(const Place& at) const { return low_ + cell_m_ * Vec3(at[0], at[1], at[2]); }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] std::size_t indexOf(const Place& at) const {
    return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(count_[1]) + static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(count_[0]) +
           static_cast<std::size_t>(at[0]);
  }
  [[nodiscard]] Place placeOf(std::size_t index) const {
    const auto row = static_cast<std::size_t>(count_[0]);
    const auto layer = row * static_cast<std::size_t>(count_[1]);
    return {static_cast<std::int32_t>(index % row), static_cast<std::int32_t>(index % layer / row),
            static_cast<std::int32_t>(index / layer)};
  }

  /// Calls visit(index) for the cells that the triangle passes through, and few others: those that its plane and its
  /// three shadows along the axes overlap (Schwarz and Seidel 2010).
  template <class Visit>
  void visit(const Corners& corners, Visit visit) const {
    const Overlap overlap(*this, corners);
    const Place first = placeAt(overlap.bounds.low - overlap.slack_m);
    const Place last = placeAt(overlap.bounds.high + overlap.slack_m);
    const auto d = static_cast<std::size_t>(overlap.steepest);
    const std::size_t u = (d + 1) % 3, v = (d + 2) % 3;
    Place at = first;
    for (at[u] = first[u]; at[u] <= last[u]; ++at[u]) {
      for (at[v] = first[v]; at[v] <= last[v]; ++at[v]) {
        at[d] = first[d];
        if (!overlap.inShadow(overlap.steepest, lowOf(at))) continue;
        const auto [from, to] = overlap.heights(lowOf(at));
        for (at[d] = std::max(first[d], cellAt(from, d)); at[d] <= std::min(last[d], cellAt(to, d)); ++at[d]) {
          const Vec3 low = lowOf(at);
          if (overlap.inShadow(static_cast<int>(u), low) && overlap.inShadow(static_cast<int>(v), low)) {
            visit(indexOf(at));
          }
        }
      }
    }
  }

 private:
  [[nodiscard]] std::int32_t cellAt(double place, std::size_t d) const {
    const double at = std::floor((place - low_[static_cast<int>(d)]) / cell_m_);
    return static_cast<std::int32_t>(std::clamp(at, 0.0, count_[d] - 1.0));
  }
  [[nodiscard]] Place placeAt(Vec3 place) const { return {cellAt(place.x, 0), cellAt(place.y, 1), cellAt(place.z, 2)}; }

  struct Overlap {
    Bounds bounds;
    Vec3 normal;
    int steepest = 0;  ///< Axis along which the normal is the longest.
    double slack_m;    ///< What rounding may do.

    Overlap(const Grid& grid, const Corners& corners)
        : bounds(boundsOf(corners)),
          normal(glm::cross(corners[1] - corners[0], corners[2] - corners[0])),
          slack_m(0x1p-16 * grid.cell_m()),
          corners_(corners),
          cell_m_(grid.cell_m()) {
      for (int d = 1; d < 3; ++d) {
        if (std::abs(normal[d]) > std::abs(normal[steepest])) steepest = d;
      }
      for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double way = normal[axis] >= 0 ? 1 : -1;
        for (int k = 0; k < 3; ++k) {
          const Vec3 edge = corners[static_cast<std::size_t>((k + 1) % 3)] - corners[static_cast<std::size_t>(k)];
          Line& line = lines_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(k)];
          line.u = -edge[v] * way;
          line.v = edge[u] * way;
          const Vec3 corner = corners[static_cast<std::size_t>(k)];
          const double reach = std::max(0.0, line.u * cell_m_) + std::max(0.0, line.v * cell_m_);
          line.offset =
              reach - line.u * corner[u] - line.v * corner[v] + slack_m * (std::abs(line.u) + std::abs(line.v));
        }
      }
    }
    /// Does the cell's shadow along the axis overlap the triangle's? Of one that is seen from its edge: perhaps.
    [[nodiscard]] bool inShadow(int axis, Vec3 low) const {
      if (normal[axis] == 0) return true;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      return std::ranges::all_of(lines_[static_cast<std::size_t>(axis)], [&](const Line& line) {
        return line.u * low[u] + line.v * low[v] + line.offset >= 0;
      });
    }
    /// Lowest and highest point of the triangle's plane over a cell's shadow, along the steepest axis.
    [[nodiscard]] std::pair<double, double> heights(Vec3 low) const {
      if (normal[steepest] == 0) return {bounds.low[steepest], bounds.high[steepest]};
      const int u = (steepest + 1) % 3, v = (steepest + 2) % 3;
      const double byU = -normal[u] / normal[steepest], byV = -normal[v] / normal[steepest];
      const double middle = corners_[0][steepest] + byU * (low[u] + cell_m_ / 2 - corners_[0][u]) +
                            byV * (low[v] + cell_m_ / 2 - corners_[0][v]);
      const double half = (std::abs(byU) + std::abs(byV)) * cell_m_ / 2 + slack_m;
      return {middle - half, middle + half};
    }

   private:
    /// u x + v y + offset >= 0: on the inner side, for some corner of the cell at (x, y).
    struct Line {
      double u, v, offset;
    };
    std::array<std::array<Line, 3>, 3> lines_;
    Corners corners_;
    double cell_m_;
  };

  Vec3 low_;
  double cell_m_;
  Place count_;
};

/// The finest that lists no more than is allowed, judged by some of the triangles.
Grid gridFor(const Bounds& bounds, std::span<const std::uint32_t> triangles,
             const std::function<Corners(std::uint32_t)>& corners) {
  constexpr std::array kAlong{128, 96, 64, 48, 32, 24, 16, 12};
  constexpr std::size_t kSamples = 256;
  const std::size_t stride = std::max<std::size_t>(1, triangles.size() / kSamples);
  const auto count = static_cast<double>(triangles.size());
  const double most = std::min(kMaxListed * count, kMaxListedOfAll);
  for (const int along : kAlong) {
    const Grid grid(bounds, along);
    double listed = 0, samples = 0;
    for (std::size_t i = 0; i < triangles.size(); i += stride, ++samples) {
      interruptionPoint();
      grid.visit(corners(triangles[i]), [&](std::size_t) { ++listed; });
    }
    if (listed / samples * count <= most) return grid;
  }
  return {bounds, 8};
}

}  // namespace

std::vector<std::uint32_t> longTriangles(std::span<const Vec3f> vertices,
                                         std::span<const std::array<std::uint32_t, 3>> triangles) {
  const auto cornersOf = [&](std::uint32_t t) {
    const auto& [a, b, c] = triangles[t];
    return Corners{Vec3(vertices[a]), Vec3(vertices[b]), Vec3(vertices[c])};
  };
  const auto count = static_cast<std::uint32_t>(triangles.size());
  if (count < kFewLong) return {};
  const auto boxOf = [&](std::uint32_t t) {
    const auto& [a, b, c] = triangles[t];
    return FloatBox(vertices[a], vertices[b], vertices[c]);
  };
  std::vector<float> lengths;
  growTo(lengths, count);
  forEach(count, [&](std::size_t t) { lengths[t] = boxOf(static_cast<std::uint32_t>(t)).longest(); });
  std::vector<float> sorted = lengths;
  const auto nearlyAll = sorted.begin() + static_cast<std::ptrdiff_t>(count - 1 - count / kFewLong);
  std::nth_element(sorted.begin(), nearlyAll, sorted.end());
  interruptionPoint();
  const float giant = kGiant * *nearlyAll;
  FloatBox all;
  forEach(count, [&](std::size_t t) {
    if (lengths[t] <= giant) all.grow(boxOf(static_cast<std::uint32_t>(t)));
  });
  const double long_m = kLongShare * Bounds{Vec3(vec3f(all.low)), Vec3(vec3f(all.high))}.longest();
  std::vector<std::uint32_t> found;
  for (std::uint32_t t = 0; t < count; ++t) {
    if (lengths[t] > long_m && lengths[t] <= giant) found.push_back(t);
  }
  if (found.size() < kFewLong) return {};
  std::vector<std::uint8_t> uses(vertices.size(), 0);
  for (const auto& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      if (uses[v] <= kMaxAtVertex) ++uses[v];
    }
  }
  std::erase_if(found, [&](std::uint32_t t) {
    return std::ranges::any_of(triangles[t], [&](std::uint32_t v) { return uses[v] > kMaxAtVertex; });
  });
  Bounds within;
  double volumes = 0;
  for (const std::uint32_t t : found) {
    within.grow(cornersOf(t));
    volumes += boundsOf(cornersOf(t)).volume();
  }
  if (found.size() < kFewLong || !(volumes > kMaxOverlap * within.volume())) found.clear();
  return found;
}

TriangleCells cellsOf(std::span<const std::uint32_t> triangles, const std::function<Corners(std::uint32_t)>& corners) {
  Bounds bounds;
  for (const std::uint32_t t : triangles) bounds.grow(corners(t));
  const Grid grid = gridFor(bounds, triangles, corners);
  std::vector<std::uint32_t> end(grid.cells(), 0);
  for (const std::uint32_t t : triangles) {
    interruptionPoint();
    grid.visit(corners(t), [&](std::size_t cell) { ++end[cell]; });
  }
  TriangleCells result;
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < end.size(); ++i) {
    const std::uint32_t count = end[i];
    if (count > 0) {
      const Vec3 low = grid.lowOf(grid.placeOf(i));
      result.cells.push_back({Vec3f(low), Vec3f(low + grid.cell_m()), begin, begin + count});
    }
    end[i] = begin;
    begin += count;
  }
  result.listed.resize(begin);
  for (const std::uint32_t t : triangles) {
    interruptionPoint();
    grid.visit(corners(t), [&](std::size_t cell) { result.listed[end[cell]++] = t; });
  }
  return result;
}

}  // namespace haptics
