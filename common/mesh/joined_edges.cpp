#include "common/mesh/joined_edges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

namespace haptics {
namespace {

struct Side {
  std::uint32_t from, to;
};

/// Of edges that one face has, as that runs along them; in the order of the faces.
std::vector<Side> openSides(const TriMesh& mesh) {
  struct Known {
    std::uint64_t edge;
    std::uint32_t number;
  };
  std::vector<Side> sides;
  std::vector<Known> known;
  sides.reserve(3 * mesh.triangles.size());
  known.reserve(3 * mesh.triangles.size());
  for (const auto [a, b, c] : mesh.triangles) {
    for (const Side side : {Side{a, b}, Side{b, c}, Side{c, a}}) {
      const std::uint64_t low = std::min(side.from, side.to), high = std::max(side.from, side.to);
      known.push_back({low << 32 | high, static_cast<std::uint32_t>(sides.size())});
      sides.push_back(side);
    }
  }
  std::ranges::sort(known, {}, &Known::edge);
  std::vector<std::uint32_t> open;
  for (std::size_t i = 0, end = 0; i < known.size(); i = end) {
    while (end < known.size() && known[end].edge == known[i].edge) ++end;
    if (end == i + 1) open.push_back(known[i].number);
  }
  std::ranges::sort(open);
  std::vector<Side> found;
  found.reserve(open.size());
  for (const std::uint32_t number : open) found.push_back(sides[number]);
  return found;
}

/// Finds open sides by where they begin.
class SidesByPlace {
 public:
  SidesByPlace(const TriMesh& mesh, const std::vector<Side>& sides, double within_m)
      : mesh_(mesh),
        sides_(sides),
        within_m_(within_m),
        cell_m_(kCell * within_m),
        prefixBits_(std::bit_width(sides.size() | 1)),
        begins_((std::size_t{1} << prefixBits_) + 1) {
    entries_.reserve(sides.size());
    for (std::uint32_t i = 0; i < sides.size(); ++i) {
      const Vec3 place = at(sides[i].from);
      entries_.push_back({keyOf(cellOf(place.x), cellOf(place.y), cellOf(place.z)), i});
    }
    std::ranges::sort(entries_, {}, [](const Entry& e) { return std::pair(e.key, e.side); });
    for (const Entry& entry : entries_) ++begins_[prefixOf(entry.key) + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  }

  /// The nearest that runs against this one, along it.
  template <class IsFree>
  [[nodiscard]] std::optional<std::uint32_t> opposite(const Side& side, IsFree isFree) const {
    std::optional<std::uint32_t> best;
    double nearest_m = std::numeric_limits<double>::infinity();
    const Vec3 end = at(side.to);
    const auto look = [&](const Entry& entry) {
      const Side& other = sides_[entry.side];
      const double ends_m = glm::distance(at(other.from), end), begins_m = glm::distance(at(other.to), at(side.from));
      if (ends_m > within_m_ || begins_m > within_m_ || !isFree(entry.side) || ends_m + begins_m >= nearest_m) return;
      nearest_m = ends_m + begins_m;
      best = entry.side;
    };
    const Vec3 low = end - within_m_, high = end + within_m_;
    for (std::int64_t x = cellOf(low.x); x <= cellOf(high.x); ++x) {
      for (std::int64_t y = cellOf(low.y); y <= cellOf(high.y); ++y) {
        for (std::int64_t z = cellOf(low.z); z <= cellOf(high.z); ++z) {
          const std::uint64_t key = keyOf(x, y, z);
          const std::span range = withPrefixOf(key);
          auto entry = std::ranges::lower_bound(range, key, {}, &Entry::key);
          for (int looked = 0; entry != range.end() && entry->key == key && looked < kMaxInACell; ++looked)
            look(*entry++);
        }
      }
    }
    return best;
  }

 private:
  /// In lengths looked within: larger looks at more sides, smaller into more cells.
  static constexpr double kCell = 4;
  static constexpr int kMaxInACell = 16;
  struct Entry {
    std::uint64_t key;
    std::uint32_t side;
  };

  [[nodiscard]] std::size_t prefixOf(std::uint64_t key) const { return key >> (64 - prefixBits_); }
  [[nodiscard]] std::span<const Entry> withPrefixOf(std::uint64_t key) const {
    const std::size_t prefix = prefixOf(key);
    return std::span(entries_).subspan(begins_[prefix], begins_[prefix + 1] - begins_[prefix]);
  }
  [[nodiscard]] Vec3 at(std::uint32_t vertex) const { return Vec3(mesh_.vertices[vertex]); }
  [[nodiscard]] std::int64_t cellOf(double place_m) const {
    return static_cast<std::int64_t>(std::floor(place_m / cell_m_));
  }
  /// Cells that share one are told apart by their sides' places.
  [[nodiscard]] static std::uint64_t keyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
    std::uint64_t key = 0;
    for (const std::int64_t cell : {x, y, z}) key = (key ^ static_cast<std::uint64_t>(cell)) * 0x9E3779B97F4A7C15U;
    return key;
  }

  const TriMesh& mesh_;
  const std::vector<Side>& sides_;
  const double within_m_, cell_m_;
  const int prefixBits_;
  std::vector<Entry> entries_;         // in the order of their keys
  std::vector<std::uint32_t> begins_;  // of the entries with each prefix of their keys
};

/// Vertices that have become one, each set at the place of its lowest number.
class VertexSets {
 public:
  VertexSets(const TriMesh& mesh, double within_m)
      : mesh_(mesh), farthest_m_(2 * within_m), of_(mesh.vertices.size()), reach_m_(mesh.vertices.size(), 0) {
    std::iota(of_.begin(), of_.end(), 0U);
  }

  /// Unless one of them would go too far.
  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = std::min(find(a), find(b)), high = std::max(find(a), find(b));
    if (low == high) return;
    const double reach_m = glm::distance(Vec3(mesh_.vertices[low]), Vec3(mesh_.vertices[high])) + reach_m_[high];
    if (reach_m > farthest_m_) return;
    of_[high] = low;
    reach_m_[low] = std::max(reach_m_[low], reach_m);
  }

  [[nodiscard]] std::uint32_t find(std::uint32_t v) {
    while (of_[v] != v) v = of_[v] = of_[of_[v]];
    return v;
  }

 private:
  const TriMesh& mesh_;
  const double farthest_m_;
  std::vector<std::uint32_t> of_;
  std::vector<double> reach_m_;  // of a set's first vertex: how far another one is
};

}  // namespace

JoinedVertices joinOpenEdges(const TriMesh& mesh, double within_m) {
  const std::vector<Side> sides = openSides(mesh);
  const SidesByPlace places(mesh, sides, within_m);
  std::vector<bool> isJoined(sides.size(), false);
  VertexSets sets(mesh, within_m);
  for (std::uint32_t i = 0; i < sides.size(); ++i) {
    if (isJoined[i]) continue;
    const auto other = places.opposite(sides[i], [&](std::uint32_t k) { return k != i && !isJoined[k]; });
    if (!other) continue;
    isJoined[i] = isJoined[*other] = true;
    sets.join(sides[i].from, sides[*other].to);
    sets.join(sides[i].to, sides[*other].from);
  }
  JoinedVertices result;
  result.becomes.reserve(mesh.vertices.size());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    result.becomes.push_back(sets.find(v));
    result.joined += result.becomes[v] != v ? 1 : 0;
  }
  return result;
}

}  // namespace haptics
