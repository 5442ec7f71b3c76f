#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// A mesh of fewer and fewer triangles by quadric error (Garland and Heckbert, Surface Simplification Using Quadric Error
/// Metrics, 1997), on OpenMesh's half-edges. The same mesh gives the same copies on every machine.
///
/// Deviations from the paper: an edge collapses into one of its vertices, so that vertices stay where they are; planes
/// count alike, whatever the area of their triangles; the cheapest quarter of the vertices goes in one sweep, each by
/// what it costs when its turn comes; and a collapse costs as much at least as it takes vertices that are gone from the
/// surface: the planes at a sharp rim hardly say where it ends. A heap for the cheapest edge of all (OpenMesh's
/// DecimaterT) takes 50 s for 870,430 triangles, this some 3 s.
///
/// Faces at which the mesh is not manifold stay, and so do their vertices.
class Decimation {
 public:
  /// A copy that strays no farther, of its longest side, is the same shape.
  static constexpr double kExact_of_longest = 1e-6;

  /// O(n) time in the triangles, some 3 us each, in which the thread may be interrupted. The mesh outlives this.
  explicit Decimation(const TriMesh& mesh);

  /// Triangles of the coarsest copy.
  [[nodiscard]] std::size_t fewest() const noexcept { return trianglesAfter_.back(); }
  /// Triangles of the copy from which only vertices within flat parts and straight lines are gone: its surface is the same
  /// within kExact_of_longest.
  [[nodiscard]] std::size_t exact() const noexcept { return exact_; }
  /// The finest copy of at most so many triangles; the coarsest where all have more. Canonical order.
  [[nodiscard]] TriMesh copyOf(std::size_t triangles) const;

 private:
  class Sweeper;

  const TriMesh& mesh_;
  std::vector<std::array<std::uint32_t, 2>> collapses_;  // vertex that goes, vertex that takes its place; in order
  std::vector<std::uint32_t> trianglesAfter_;            // so many collapses: one more than there are
  std::size_t exact_;
};

}  // namespace haptics
