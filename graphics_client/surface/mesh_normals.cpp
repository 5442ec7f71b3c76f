#include "graphics_client/surface/mesh_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

namespace haptics {
namespace {

Vec3 corner(const TriMesh& mesh, const TriangleIndices& triangle, std::size_t k) {
  return Vec3(mesh.vertices[triangle[k % 3]]);
}

/// Unit normals; zero for faces without area.
std::vector<Vec3> faceNormals(const TriMesh& mesh) {
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 n = glm::cross(corner(mesh, t, 1) - corner(mesh, t, 0), corner(mesh, t, 2) - corner(mesh, t, 0));
    const double length = glm::length(n);
    normals.push_back(length > 0 ? n / length : Vec3(0));
  }
  return normals;
}

/// A face's normal at one of its corners, with its weight in the vertex's.
Vec3 weightedNormal(const TriMesh& mesh, const TriangleIndices& triangle, std::size_t k) {
  const Vec3 a = corner(mesh, triangle, k + 1) - corner(mesh, triangle, k);
  const Vec3 b = corner(mesh, triangle, k + 2) - corner(mesh, triangle, k);
  const double scale = squaredLength(a) * squaredLength(b);
  return scale > 0 ? glm::cross(a, b) / scale : Vec3(0);
}

/// Triangle corners, numbered 3 * triangle + corner, gathered by the vertex they stand at.
struct CornersByVertex {
  std::vector<std::size_t> begin;  ///< Of each vertex, and the end of the last.
  std::vector<std::size_t> corners;

  explicit CornersByVertex(const TriMesh& mesh) : begin(mesh.vertices.size() + 1), corners(3 * mesh.triangles.size()) {
    for (const TriangleIndices& t : mesh.triangles) {
      for (const std::uint32_t v : t) ++begin[v + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t c = 0; c < corners.size(); ++c) corners[next[mesh.triangles[c / 3][c % 3]]++] = c;
  }
};

/// The corners at one vertex, joined into smooth fans. Kept from vertex to vertex for its memory.
class Fans {
 public:
  Fans(const TriMesh& mesh, const std::vector<Vec3>& normals, double cosCrease, std::span<const Crease> creases)
      : mesh_(mesh), normals_(normals), cosCrease_(cosCrease), creases_(creases) {}

  void join(std::uint32_t vertex, std::span<const std::size_t> corners) {
    parent_.resize(corners.size());
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    spokes_.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const TriangleIndices& t = mesh_.triangles[corners[i] / 3];
      spokes_.emplace_back(t[(corners[i] % 3 + 1) % 3], i);
      spokes_.emplace_back(t[(corners[i] % 3 + 2) % 3], i);
    }
    std::ranges::sort(spokes_);
    for (std::size_t s = 1; s < spokes_.size(); ++s) {
      if (spokes_[s - 1].first != spokes_[s].first) continue;
      const std::size_t a = spokes_[s - 1].second, b = spokes_[s].second;
      if (glm::dot(normals_[corners[a] / 3], normals_[corners[b] / 3]) < cosCrease_) continue;
      const auto [first, second] = std::minmax(vertex, spokes_[s].first);
      if (!std::ranges::binary_search(creases_, Crease{first, second})) parent_[root(a)] = root(b);
    }
  }

  [[nodiscard]] std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

 private:
  const TriMesh& mesh_;
  const std::vector<Vec3>& normals_;
  double cosCrease_;
  std::span<const Crease> creases_;
  std::vector<std::size_t> parent_;
  std::vector<std::pair<std::uint32_t, std::size_t>> spokes_;  // other end of an edge at the vertex, corner
};

}  // namespace

ShadedMesh shadeMesh(const TriMesh& mesh, double crease_rad, std::span<const Crease> creases) {
  const std::vector<Vec3> normals = faceNormals(mesh);
  const CornersByVertex incident(mesh);
  Fans fans(mesh, normals, std::cos(crease_rad), creases);
  ShadedMesh shaded;
  shaded.triangles.resize(mesh.triangles.size());
  shaded.source.reserve(mesh.vertices.size());
  shaded.normals.reserve(mesh.vertices.size());
  std::vector<Vec3> sums;
  std::vector<std::uint32_t> shadedVertex;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::span corners(incident.corners.begin() + static_cast<std::ptrdiff_t>(incident.begin[v]),
                            incident.begin[v + 1] - incident.begin[v]);
    fans.join(v, corners);
    sums.assign(corners.size(), Vec3(0));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      sums[fans.root(i)] += weightedNormal(mesh, mesh.triangles[corners[i] / 3], corners[i] % 3);
    }
    shadedVertex.assign(corners.size(), 0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (fans.root(i) != i) continue;
      const double length = glm::length(sums[i]);
      shadedVertex[i] = static_cast<std::uint32_t>(shaded.source.size());
      shaded.source.push_back(v);
      shaded.normals.emplace_back(length > 0 ? sums[i] / length : Vec3(0, 0, 1));
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      shaded.triangles[corners[i] / 3][corners[i] % 3] = shadedVertex[fans.root(i)];
    }
  }
  return shaded;
}

bool isClosed(const TriMesh& mesh) {  // every edge is run along once in each direction
  std::vector<std::pair<std::uint32_t, std::uint32_t>> forward, backward;
  forward.reserve(3 * mesh.triangles.size());
  backward.reserve(3 * mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      forward.emplace_back(t[k], t[(k + 1) % 3]);
      backward.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::ranges::sort(forward);
  std::ranges::sort(backward);
  return forward == backward && std::ranges::adjacent_find(forward) == forward.end();
}

}  // namespace haptics
