#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

[[nodiscard]] double areaOf_m2(const TriMesh& mesh) noexcept;

/// A place on a mesh.
struct MeshSample {
  Vec3 point;
  Vec3 normal;  ///< Of its triangle, unit.
};

/// Whether two places that are near each other are on the same side of a sheet: their normals are less than 120 degrees
/// apart.
[[nodiscard]] inline bool areOnOneSide(const MeshSample& a, const MeshSample& b) noexcept {
  return glm::dot(a.normal, b.normal) > -0.5;
}

/// Distance between neighbours if so many samples were laid on the area in a hexagonal grid.
[[nodiscard]] double evenSpacing_m(double area_m2, std::size_t count) noexcept;

/// So many samples of the mesh, evenly spaced and random: of five times as many, uniform over the area, those are taken
/// away one by one that have the nearest neighbours (Yuksel 2015, sample elimination with alpha = 8) on their side. In
/// the order of the triangles. The same samples on every machine (basic operations alone).
/// Refused, with an empty field: a mesh that has very many sheets above each other, each within the spacing of the next.
[[nodiscard]] Result<std::vector<MeshSample>> evenSamples(const TriMesh& mesh, std::size_t count, std::uint32_t seed);

/// Pairs of samples that are nearer than the radius and on one side, for each sample those with all of its neighbours.
struct Neighborhoods {
  struct Neighbor {
    std::uint32_t sample;
    float distance_m;
  };
  std::vector<std::size_t> first;  ///< One more than there are samples.
  std::vector<Neighbor> all;
};
/// Refused, with an empty field: as evenSamples().
[[nodiscard]] Result<Neighborhoods> neighborhoodsOf(const std::vector<MeshSample>& samples, double radius_m);

}  // namespace haptics
