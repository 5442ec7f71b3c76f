#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/box_tree.h"
#include "common/mesh/tri_mesh.h"
#include "common/mesh/work.h"

namespace haptics {

/// Where a mesh passes through itself: pairs of triangles of which a side of one pierces the other. A side that ends at
/// a vertex of the other does not pierce it. Metres.
class SelfIntersectionSearch {
 public:
  using Pair = std::array<std::uint32_t, 2>;

  /// Keeps the mesh by reference.
  explicit SelfIntersectionSearch(const TriMesh& mesh);
  SelfIntersectionSearch(const SelfIntersectionSearch&) = delete;
  SelfIntersectionSearch& operator=(const SelfIntersectionSearch&) = delete;

  /// To be called when vertices of these triangles were moved.
  void refit(std::span<const std::uint32_t> triangles) { tree_.refit(triangles); }
  /// All pairs, each once, in no particular order. None when the work does not suffice: long triangles and fans meet too
  /// many others.
  [[nodiscard]] std::optional<std::vector<Pair>> all(Work& work) const;
  /// Is one of these triangles in such a pair? True as well when the work does not suffice.
  [[nodiscard]] bool any(std::span<const std::uint32_t> triangles, Work& work) const;

  /// Limit of the work of all(). A sane mesh needs some 150 units a triangle, with many fans 500.
  [[nodiscard]] static Work allowance(const TriMesh& mesh) { return {mesh.triangles.size(), 512}; }

 private:
  class PairWalk;
  struct Face {
    TriangleIndices corners;
    std::array<Vec3, 3> at;
    Vec3 normal;
  };

  [[nodiscard]] Box boxOf(std::uint32_t triangle) const;
  [[nodiscard]] Face faceOf(std::uint32_t triangle) const;
  [[nodiscard]] static bool intersect(const Face& a, const Face& b);
  [[nodiscard]] static bool pierces(const Face& a, const std::array<double, 3>& heights, const Face& b);

  const TriMesh& mesh_;
  BoxTree tree_;
};

}  // namespace haptics
