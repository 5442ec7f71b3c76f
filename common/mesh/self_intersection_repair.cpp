#include "common/mesh/self_intersection_repair.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <vector>

#include "common/mesh/hole_filling.h"
#include "common/mesh/patch.h"
#include "common/mesh/self_intersection_search.h"

namespace haptics {
namespace {

/// Of how far mending may change the surface: how wide a crack is, on average, that is filled however deep it is, because
/// nothing could have felt its bottom. Larger closes slots that are meant.
constexpr double kThin = 1.0 / 16;

/// Disjoint sets of vertices.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Units for each triangle of the mesh. Larger mends more of a mesh that is torn everywhere, and takes as much longer.
constexpr std::int64_t kRepairWorkEach = 2048;

/// The vertices of the triangles that cross, one list for each place where they do, in the order of their first vertices.
std::vector<Numbers> knotsOf(const TriMesh& mesh, std::span<const SelfIntersectionSearch::Pair> pairs) {
  Sets pieces(mesh.vertices.size());
  for (const auto [a, b, c] : mesh.triangles) {
    pieces.join(a, b);
    pieces.join(a, c);
  }
  Sets places(mesh.vertices.size());
  Numbers all;
  for (const auto& [a, b] : pairs) {
    if (pieces.find(mesh.triangles[a][0]) != pieces.find(mesh.triangles[b][0])) continue;
    for (const std::uint32_t t : {a, b}) {
      for (const std::uint32_t v : mesh.triangles[t]) {
        places.join(mesh.triangles[a][0], v);
        all.push_back(v);
      }
    }
  }
  makeUnique(all);
  std::vector<Numbers> knots;
  std::map<std::uint32_t, std::size_t> knotOf;
  for (const std::uint32_t v : all) {
    const auto [at, isNew] = knotOf.emplace(places.find(v), knots.size());
    if (isNew) knots.emplace_back();
    knots[at->second].push_back(v);
  }
  return knots;
}

/// Is it one that was cut and not replaced? It names one vertex three times until the end.
bool isCut(const TriangleIndices& triangle) { return triangle[0] == triangle[1]; }

/// Cuts and fills.
class SelfIntersectionRepair {
 public:
  SelfIntersectionRepair(TriMesh& mesh, SelfIntersectionSearch& search, double farthest_m, Work& work)
      : mesh_(mesh),
        search_(search),
        farthest_m_(farthest_m),
        work_(work),
        fans_(mesh),
        changed_(mesh.triangles.size(), false) {}

  /// Returns whether the place was mended.
  bool repairSelfIntersections(const Numbers& knot, RepairReport& result) {
    constexpr int kMaxRings = 16;
    constexpr std::size_t kMaxTrianglesAround = 4096;
    Numbers vertices = knot;
    for (int rings = 0; rings <= kMaxRings; ++rings) {
      const auto cut = fans_.around(vertices, kMaxTrianglesAround, work_);
      if (!cut) return false;
      if (replace(*cut, result)) return true;
      if (work_.isOver()) return false;
      for (const std::uint32_t t : *cut) {
        vertices.insert(vertices.end(), mesh_.triangles[t].begin(), mesh_.triangles[t].end());
      }
      makeUnique(vertices);
    }
    return false;
  }

  /// The pairs that are left, with the triangles' numbers in the mesh without those that were cut.
  [[nodiscard]] std::vector<SelfIntersectionSearch::Pair> left(std::vector<SelfIntersectionSearch::Pair> pairs) const {
    std::erase_if(pairs, [&](const auto& pair) { return changed_[pair[0]] || changed_[pair[1]]; });
    std::vector<std::uint32_t> number(mesh_.triangles.size());
    std::uint32_t next = 0;
    for (std::size_t t = 0; t < number.size(); ++t) number[t] = isCut(mesh_.triangles[t]) ? next : next++;
    for (auto& [a, b] : pairs) {
      a = number[a];
      b = number[b];
    }
    return pairs;
  }

 private:
  bool replace(const Numbers& cut, RepairReport& result) {
    const auto rims = rimsOf(mesh_, fans_, cut, work_);
    if (!rims) return false;
    const Patch before = patchOf(mesh_.vertices, trianglesOf(cut));
    Patch after;
    Numbers out = cut;
    std::vector<TriangleIndices> in;
    for (std::size_t i = 0; i < rims->size(); ++i) {
      const auto isTaken = [&](std::uint32_t a, std::uint32_t b) {
        return joinsOutside(fans_, mesh_, cut, a, b, work_);
      };
      const auto filling = fillHole(mesh_.vertices, (*rims)[i], isTaken, work_);
      if (!filling) return false;
      const Numbers island = islandIn(mesh_, fans_, cut, *rims, i, work_);
      const Patch lid = patchOf(mesh_.vertices, *filling);
      after.insert(after.end(), lid.begin(), lid.end());
      if (island.empty()) {
        in.insert(in.end(), filling->begin(), filling->end());
      } else if (isClosedOff(island, lid, before)) {
        out.insert(out.end(), island.begin(), island.end());
      } else {
        return false;
      }
    }
    makeUnique(out);
    const auto farthest_m = farthestFrom(before, after, work_);
    if (!farthest_m) return false;
    const double void_m3 = volumeUnder(after) - volumeUnder(before);
    const bool isFar = *farthest_m > farthest_m_;
    const bool isThinCrack = void_m3 >= 0 && void_m3 <= kThin * farthest_m_ * areaOf(before) / 2;
    if ((isFar && !isThinCrack) || !exchange(out, in)) return false;
    result.trianglesCut += out.size();
    result.trianglesFilled += in.size();
    if (!isFar) result.farthest_m = std::max(result.farthest_m, *farthest_m);
    return true;
  }

  [[nodiscard]] std::vector<TriangleIndices> trianglesOf(const Numbers& numbers) const {
    std::vector<TriangleIndices> triangles;
    for (const std::uint32_t t : numbers) triangles.push_back(mesh_.triangles[t]);
    return triangles;
  }

  /// Is an island the wall of a hollow in the body whose mouth was where the mesh crossed? Nothing can feel it then.
  [[nodiscard]] bool isClosedOff(const Numbers& island, const Patch& lid, const Patch& cut) {
    const Patch wall = patchOf(mesh_.vertices, trianglesOf(island));
    if (volumeUnder(wall) + volumeUnder(lid) >= 0) return false;
    const auto farthest_m = farthestFrom(lid, cut, work_);
    return farthest_m && *farthest_m <= farthest_m_;
  }

  /// Puts triangles in the place of others, unless they cross something.
  bool exchange(const Numbers& out, const std::vector<TriangleIndices>& in) {
    const auto isChanged = [&](std::uint32_t t) { return changed_[t]; };
    if (in.size() > out.size() || std::any_of(out.begin(), out.end(), isChanged)) return false;
    const std::vector<TriangleIndices> before = trianglesOf(out);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::uint32_t v = before[i][0];
      mesh_.triangles[out[i]] = i < in.size() ? in[i] : TriangleIndices{v, v, v};
    }
    search_.refit(out);
    if (search_.any(out, work_)) {
      for (std::size_t i = 0; i < out.size(); ++i) mesh_.triangles[out[i]] = before[i];
      search_.refit(out);
      return false;
    }
    for (const std::uint32_t t : out) changed_[t] = true;
    return true;
  }

  TriMesh& mesh_;
  SelfIntersectionSearch& search_;
  double farthest_m_;
  Work& work_;
  Fans fans_;
  std::vector<bool> changed_;
};

/// Back to canonical order: without what was cut, vertices in the order of first use.
void dropCut(TriMesh& mesh) {
  std::erase_if(mesh.triangles, isCut);
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  std::vector<Vec3f> vertices;
  for (TriangleIndices& t : mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(mesh.vertices[v]);
      }
      v = number[v];
    }
  }
  mesh.vertices = std::move(vertices);
}

}  // namespace

RepairReport repairSelfIntersections(TriMesh& mesh, bool closed, double farthest_m) {
  constexpr int kMaxPasses = 4;  // places that touch each other are mended in turn
  RepairReport result;
  Work work(mesh.triangles.size(), kRepairWorkEach);
  std::vector<SelfIntersectionSearch::Pair> pairs;
  for (int pass = 0; pass < kMaxPasses && !work.isOver(); ++pass) {
    SelfIntersectionSearch search(mesh);
    if (pass == 0) {
      Work searching = SelfIntersectionSearch::allowance(mesh);
      auto all = search.all(searching);
      result.searched = all.has_value();
      pairs = std::move(all).value_or(std::vector<SelfIntersectionSearch::Pair>());
      result.selfIntersections = result.selfIntersectionsLeft = pairs.size();
    }
    if (pairs.empty() || !closed || !(farthest_m > 0)) break;
    SelfIntersectionRepair repair(mesh, search, farthest_m, work);
    bool any = false;
    for (const Numbers& knot : knotsOf(mesh, pairs)) {
      any = (!work.isOver() && repair.repairSelfIntersections(knot, result)) || any;
    }
    if (!any) break;
    pairs = repair.left(std::move(pairs));  // what is new crosses nothing
    result.selfIntersectionsLeft = pairs.size();
    dropCut(mesh);
  }
  result.finished = !work.isOver();
  return result;
}

}  // namespace haptics
