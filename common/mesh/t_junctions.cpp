#include "common/mesh/t_junctions.h"

#include <algorithm>
#include <cmath>

namespace haptics {
namespace {

/// Of the extent: 16 times the rounding of a float coordinate. Larger takes near misses for junctions.
constexpr double kOn = 0x1p-20;

/// Vertices sorted by the cell of a grid that they lie in.
class Grid {
 public:
  using Cell = std::array<std::int64_t, 3>;

  Grid(const std::vector<Vec3f>& vertices, const std::vector<std::uint32_t>& filed, Vec3 low, double cell_m)
      : low_(low), cell_m_(cell_m) {
    entries_.reserve(filed.size());
    for (const std::uint32_t v : filed) entries_.push_back({keyOf(cellOf(Vec3(vertices[v]))), v});
    std::sort(entries_.begin(), entries_.end());
  }

  /// Calls any(vertex) for those in the cells that the box overlaps, until it returns true, and then returns true.
  template <class Any>
  [[nodiscard]] bool anyIn(Vec3 low, Vec3 high, Any any) const {
    const Cell first = cellOf(low), last = cellOf(high);
    for (std::int64_t x = first[0]; x <= last[0]; ++x) {
      for (std::int64_t y = first[1]; y <= last[1]; ++y) {  // cells along z follow each other
        auto at = std::lower_bound(entries_.begin(), entries_.end(), Entry{keyOf({x, y, first[2]}), 0});
        const std::uint64_t end = keyOf({x, y, last[2]});
        for (; at != entries_.end() && at->key <= end; ++at) {
          if (any(at->vertex)) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr int kBits = 21;  // of a cell's number in each direction
  struct Entry {
    std::uint64_t key;
    std::uint32_t vertex;
    auto operator<=>(const Entry&) const = default;
  };

  [[nodiscard]] Cell cellOf(Vec3 place) const {
    Cell cell;
    for (int d = 0; d < 3; ++d) {
      const double at = std::floor((place[d] - low_[d]) / cell_m_);
      cell[static_cast<std::size_t>(d)] = static_cast<std::int64_t>(std::clamp(at, 0.0, (1 << kBits) - 1.0));
    }
    return cell;
  }
  static std::uint64_t keyOf(const Cell& cell) {
    return static_cast<std::uint64_t>(cell[0] << 2 * kBits | cell[1] << kBits | cell[2]);
  }

  Vec3 low_;
  double cell_m_;
  std::vector<Entry> entries_;
};

bool liesOn(Vec3 place, Vec3 a, Vec3 b, double tolerance_m) {
  const Vec3 along = b - a;
  const double time = glm::dot(place - a, along) / squaredLength(along);
  if (!(time > 0 && time < 1)) return false;
  const double near2 = tolerance_m * tolerance_m;
  return squaredLength(a + along * time - place) <= near2 && squaredLength(place - a) > near2 &&
         squaredLength(place - b) > near2;
}

}  // namespace

std::uint64_t countTJunctions(const std::vector<Vec3f>& vertices, const std::vector<EdgeIndices>& boundary) {
  if (boundary.empty()) return 0;
  std::vector<std::uint32_t> ends;
  Vec3 low(vertices[boundary.front()[0]]), high(low);
  double length_m = 0;
  for (const auto [a, b] : boundary) {
    ends.insert(ends.end(), {a, b});
    const Vec3 from(vertices[a]), to(vertices[b]);
    low = glm::min(low, glm::min(from, to));
    high = glm::max(high, glm::max(from, to));
    length_m += glm::distance(from, to);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const double extent_m = std::max(glm::length(low), glm::length(high));
  const double tolerance_m = kOn * extent_m;
  // An edge is looked at in pieces of a cell's length: of all edges together no more than twice as many as edges.
  const double cell_m = std::max(length_m / static_cast<double>(boundary.size()), 2 * tolerance_m);
  const Grid grid(vertices, ends, low, cell_m);

  return static_cast<std::uint64_t>(std::count_if(boundary.begin(), boundary.end(), [&](const EdgeIndices& edge) {
    const Vec3 a(vertices[edge[0]]), b(vertices[edge[1]]);
    const auto isOn = [&](std::uint32_t v) {
      return v != edge[0] && v != edge[1] && liesOn(Vec3(vertices[v]), a, b, tolerance_m);
    };
    const double pieces = std::ceil(glm::distance(a, b) / cell_m);
    for (double i = 0; i < pieces; ++i) {
      const Vec3 from = glm::mix(a, b, i / pieces), to = glm::mix(a, b, (i + 1) / pieces);
      if (grid.anyIn(glm::min(from, to) - tolerance_m, glm::max(from, to) + tolerance_m, isOn)) return true;
    }
    return false;
  }));
}

}  // namespace haptics
