#include "graphics_client/surface/refined_mesh.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace haptics {
namespace {

/// When the triangles would be too many, edges have to be longer by this factor before they are cut.
constexpr double kCoarser = 1.12;

constexpr std::size_t next(std::size_t k) { return (k + 1) % 3; }

std::uint64_t keyOf(std::uint32_t a, std::uint32_t b) {
  const auto [first, second] = std::minmax(a, b);
  return std::uint64_t{first} << 32U | second;
}

/// One round of cutting after another. Normals stay sums over the corners of the mesh's triangles, so that halving them
/// along with the edges is Eq. (1).
class Cutter {
 public:
  explicit Cutter(RefinedMesh& mesh) : mesh_(mesh) {}

  void cutTo(double longestEdge_m, std::size_t maxTriangles) {
    for (;;) {
      std::size_t cuts = countCuts(longestEdge_m);
      while (cuts > 0 && mesh_.triangles.size() + cuts > maxTriangles) {
        longestEdge_m *= kCoarser;
        cuts = countCuts(longestEdge_m);
      }
      if (cuts == 0) return;
      cutOnce(longestEdge_m);
    }
  }

  [[nodiscard]] double longestEdge_m() const {
    double longest = 0;
    for (const TriangleIndices& t : mesh_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, length_m(t, k));
    }
    return longest;
  }

 private:
  [[nodiscard]] const Vec3& placeOf(std::uint32_t vertex) const { return mesh_.places[mesh_.place[vertex]]; }

  [[nodiscard]] double length_m(const TriangleIndices& t, std::size_t k) const {
    return glm::distance(placeOf(t[k]), placeOf(t[next(k)]));
  }

  /// Triangles that a round would add.
  [[nodiscard]] std::size_t countCuts(double longestEdge_m) const {
    std::size_t cuts = 0;
    for (const TriangleIndices& t : mesh_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) cuts += length_m(t, k) > longestEdge_m;
    }
    return cuts;
  }

  void cutOnce(double longestEdge_m) {
    middles_.clear();
    middlePlaces_.clear();
    triangles_.clear();
    rims_.clear();
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const TriangleIndices t = mesh_.triangles[i];
      std::array<bool, 3> isCut;
      for (std::size_t k = 0; k < 3; ++k) isCut[k] = length_m(t, k) > longestEdge_m;
      cut(t, mesh_.rims[i], isCut);
    }
    std::swap(mesh_.triangles, triangles_);
    std::swap(mesh_.rims, rims_);
  }

  void cut(const TriangleIndices& t, unsigned rims, const std::array<bool, 3>& isCut) {
    const auto cuts = std::ranges::count(isCut, true);
    if (cuts == 0) return add(t, rims);
    if (cuts == 3) {
      const std::uint32_t m[3] = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
      for (std::size_t k = 0; k < 3; ++k) {  // corner k, with halves of its edges
        const std::size_t before = next(next(k));
        add({t[k], m[k], m[before]}, (rims >> k & 1U) | (rims >> before & 1U) << 2U);
      }
      return add({m[0], m[1], m[2]}, 0);
    }
    // Turned so that with one cut it is edge 0 that is cut, with two it is edge 2 that is whole.
    const bool wanted = cuts == 1;
    const auto k = static_cast<std::size_t>(std::ranges::find(isCut, wanted) - isCut.begin());
    const std::size_t first = wanted ? k : next(k);
    const std::uint32_t a = t[first], b = t[next(first)], c = t[next(next(first))];
    const unsigned ab = rims >> first & 1U, bc = rims >> next(first) & 1U, ca = rims >> next(next(first)) & 1U;
    const std::uint32_t onAb = middle(a, b);
    if (cuts == 1) {
      add({a, onAb, c}, ab | ca << 2U);
      return add({onAb, b, c}, ab | bc << 1U);
    }
    const std::uint32_t onBc = middle(b, c);
    add({onAb, b, onBc}, ab | bc << 1U);
    if (glm::distance(placeOf(a), placeOf(onBc)) < glm::distance(placeOf(onAb), placeOf(c))) {
      add({a, onAb, onBc}, ab);
      add({a, onBc, c}, bc << 1U | ca << 2U);
    } else {
      add({a, onAb, c}, ab | ca << 2U);
      add({onAb, onBc, c}, bc << 1U);
    }
  }

  void add(const TriangleIndices& t, unsigned rims) {
    triangles_.push_back(t);
    rims_.push_back(static_cast<std::uint8_t>(rims));
  }

  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const auto [at, isNew] = middles_.try_emplace(keyOf(a, b), static_cast<std::uint32_t>(mesh_.place.size()));
    if (isNew) {
      const std::uint32_t place = middlePlace(mesh_.place[a], mesh_.place[b]);
      mesh_.place.push_back(place);
      mesh_.normals.push_back((mesh_.normals[a] + mesh_.normals[b]) / 2.0);
    }
    return at->second;
  }

  std::uint32_t middlePlace(std::uint32_t a, std::uint32_t b) {
    const auto [at, isNew] = middlePlaces_.try_emplace(keyOf(a, b), static_cast<std::uint32_t>(mesh_.places.size()));
    if (isNew) {
      mesh_.parents.push_back({a, b});
      mesh_.places.push_back((mesh_.places[a] + mesh_.places[b]) / 2.0);
    }
    return at->second;
  }

  RefinedMesh& mesh_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_, middlePlaces_;  // by edge, of this round
  std::vector<TriangleIndices> triangles_;
  std::vector<std::uint8_t> rims_;
};

}  // namespace

RefinedMesh refine(const TriMesh& mesh, const ShadedMesh& shaded, double longestEdge_m, std::size_t maxTriangles) {
  constexpr std::uint8_t kAllRims = 7;
  RefinedMesh refined{.places = {mesh.vertices.begin(), mesh.vertices.end()},
                      .parents = {},
                      .place = shaded.source,
                      .normals = {shaded.normals.begin(), shaded.normals.end()},
                      .triangles = shaded.triangles,
                      .rims = std::vector<std::uint8_t>(shaded.triangles.size(), kAllRims)};
  Cutter cutter(refined);
  cutter.cutTo(longestEdge_m, maxTriangles);
  refined.longestEdge_m = cutter.longestEdge_m();
  for (Vec3& normal : refined.normals) {
    const double length = glm::length(normal);
    normal = length > 0 ? normal / length : Vec3(0, 0, 1);
  }
  return refined;
}

}  // namespace haptics
