#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/interruption/grow.h"
#include "common/mesh/import.h"
#include "common/mesh/joined_edges.h"
#include "common/mesh/topology.h"

// Canonical order is a function of the triangles' geometry alone. Vertices at one place (equal float32 coordinates
// after scaling) are one; triangles stay in the order given, each with its winding and first corner; vertices are
// numbered in the order in which the kept triangles first name them. So the order of vertices in the file, vertices
// that no triangle names, vertices given more than once and the sign of zero change nothing; the order of triangles
// does.
namespace haptics {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

std::string number(std::uint64_t n) { return std::to_string(n); }

Result<void> checkOptions(const ImportOptions& options) {
  const auto good = [](double x) { return std::isfinite(x) && x > 0; };
  if (!good(options.unit_m.value_or(1)))
    return refused("unit_m", "must be finite and > 0: metres per unit of the file");
  if (options.largestExtent_m && !good(*options.largestExtent_m)) {
    return refused("largest_extent_m", "must be finite and > 0, in metres");
  }
  return {};
}

Result<void> checkInput(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles) {
  if (triangles.empty())
    return refused("", std::string("holds no face") + (vertices.empty() ? "" : " (a point cloud?)") +
                           "; a mesh needs at least one triangle");
  // Files may repeat each vertex for each triangle that names it, so up to three times as many may come in.
  if (vertices.size() > 3 * kMaxTriangles || triangles.size() > kMaxTriangles) {
    return refused("", "holds " + number(triangles.size()) + " triangles and " + number(vertices.size()) +
                           " vertices; at most " + number(kMaxTriangles) + " triangles are taken");
  }
  return {};
}

/// Whether a triangle names the vertex. Refused if one that is named is not finite.
Result<std::vector<bool>> usedOf(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles) {
  std::vector<bool> used(vertices.size(), false);
  for (const TriangleIndices& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      if (!isFinite(vertices[v])) return refused("", "vertex " + number(v) + " (from 0) is not finite");
      used[v] = true;
    }
  }
  return used;
}

/// x_metres = (x_file - centre) * scale.
struct Scaling {
  double scale;
  Vec3 centre;
};

Result<Scaling> scalingOf(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles,
                          const ImportOptions& options) {
  if (!options.largestExtent_m) return Scaling{options.unit_m.value_or(1), Vec3(0)};
  Vec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (const TriangleIndices& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      low = glm::min(low, vertices[v]);
      high = glm::max(high, vertices[v]);
    }
  }
  const Vec3 extent = high - low;
  const double largest = std::max({extent.x, extent.y, extent.z});
  const double scale = *options.largestExtent_m / largest;
  if (!std::isnormal(scale)) {
    return refused("largest_extent_m", "the mesh's longest side is " + std::to_string(largest) +
                                           " units of the file, which cannot be scaled to the length asked for");
  }
  return Scaling{scale, low / 2.0 + high / 2.0};
}

struct Scaled {
  std::vector<Vec3f> metres;
  double rounding_m = 0;  ///< Largest distance from the exact place.
};

/// Vertices that are not used may be anything; those that do not fit become 0.
Result<Scaled> scaled(const std::vector<Vec3>& vertices, const std::vector<bool>& used, const Scaling& scaling) {
  Scaled result;
  result.metres.reserve(vertices.size());
  double farthest2_m2 = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3 exact = (vertices[i] - scaling.centre) * scaling.scale;
    constexpr double kLargest = std::numeric_limits<float>::max();
    const bool fits = glm::all(glm::lessThanEqual(glm::abs(exact), Vec3(kLargest)));
    if (!fits && used[i]) {
      return refused("", "vertex " + number(i) + " (from 0) does not fit into float32 after scaling by " +
                             std::to_string(scaling.scale));
    }
    result.metres.push_back(fits ? Vec3f(exact) + 0.0F : Vec3f(0));  // -0 + 0 is +0
    const Vec3 off = exact - Vec3(result.metres.back());
    if (used[i]) farthest2_m2 = std::max(farthest2_m2, glm::dot(off, off));
  }
  result.rounding_m = std::sqrt(farthest2_m2);
  return result;
}

/// For each vertex, the number of the first one at the same place.
std::vector<std::uint32_t> firstAtSamePlace(const std::vector<Vec3f>& vertices) {
  const std::size_t capacity = std::bit_ceil(2 * vertices.size() + 1);
  std::vector<std::uint32_t> table(capacity, kNone);
  std::vector<std::uint32_t> first(vertices.size());
  forEach(vertices.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {  // Fibonacci hashing: the odd number next to 2^64 / golden ratio
      hash = (std::rotl(hash, 29) ^ std::bit_cast<std::uint32_t>(vertices[v][axis])) * 0x9E3779B97F4A7C15U;
    }
    std::size_t slot = (hash ^ hash >> 32) & (capacity - 1);
    while (table[slot] != kNone && vertices[table[slot]] != vertices[v]) slot = (slot + 1) & (capacity - 1);
    if (table[slot] == kNone) table[slot] = v;
    first[v] = table[slot];
  });
  return first;
}

std::uint64_t dropOutOfRange(std::vector<TriangleIndices>& triangles, std::size_t vertexCount) {
  return std::erase_if(triangles, [vertexCount](const TriangleIndices& triangle) {
    return std::any_of(triangle.begin(), triangle.end(), [=](std::uint32_t v) { return v >= vertexCount; });
  });
}

struct OrderedMesh {
  TriMesh mesh;
  std::vector<std::uint32_t> source;  // of each vertex, which it was
};

/// Numbers vertices in the order of first use by triangles that have area.
OrderedMesh ordered(const std::vector<Vec3f>& vertices, const std::vector<TriangleIndices>& triangles,
                    const std::vector<std::uint32_t>& first) {
  OrderedMesh made;
  TriMesh& mesh = made.mesh;
  std::vector<std::uint32_t> canonical(vertices.size(), kNone);
  forEach(triangles.size(), [&](std::size_t t) {
    TriangleIndices corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = first[triangles[t][k]];
    // Corners at one place make no area.
    if (!hasArea(vertices[corners[0]], vertices[corners[1]], vertices[corners[2]])) return;
    for (std::uint32_t& corner : corners) {
      std::uint32_t& id = canonical[corner];
      if (id == kNone) {
        id = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(vertices[corner]);
        made.source.push_back(corner);
      }
      corner = id;
    }
    mesh.triangles.push_back(corners);
  });
  return made;
}

/// Vertices that only rounding keeps apart, so that the surface has a crack that nobody can feel, are one.
void closeCracks(ImportedMesh& result) {
  auto& [mesh, report, source] = result;
  constexpr double kRounding = 0x1p-20;  // of the largest coordinate: as narrow as a gap that the contact closes
  if (report.boundaryEdges == 0) return;
  const Vec3 farthest_m = glm::max(glm::abs(report.boxMin_m), glm::abs(report.boxMax_m));
  const JoinedVertices vertices = joinOpenEdges(mesh, kRounding * std::max({farthest_m.x, farthest_m.y, farthest_m.z}));
  if (vertices.joined == 0) return;
  OrderedMesh closed = ordered(mesh.vertices, mesh.triangles, vertices.becomes);
  if (closed.mesh.triangles.empty()) return;
  mesh = std::move(closed.mesh);
  for (std::uint32_t& v : closed.source) v = source[v];
  source = std::move(closed.source);
  report.verticesJoined = vertices.joined;
  describeTopology(mesh, report);
}

}  // namespace

Result<ImportedMesh> canonicalise(const std::vector<Vec3>& vertices, std::vector<TriangleIndices> triangles,
                                  const ImportOptions& options) {
  if (auto ok = checkOptions(options); !ok) return tl::unexpected(std::move(ok).error());
  if (auto ok = checkInput(vertices, triangles); !ok) return tl::unexpected(std::move(ok).error());

  ImportedMesh result;
  MeshReport& report = result.report;
  report.verticesInFile = vertices.size();
  report.trianglesInFile = triangles.size();
  report.droppedOutOfRange = dropOutOfRange(triangles, vertices.size());
  if (triangles.empty()) return refused("", "every triangle names a vertex that is not there");

  const auto used = usedOf(vertices, triangles);
  if (!used) return tl::unexpected(used.error());
  const auto scaling = scalingOf(vertices, triangles, options);
  if (!scaling) return tl::unexpected(scaling.error());
  const auto metres = scaled(vertices, *used, *scaling);
  if (!metres) return tl::unexpected(metres.error());
  const std::vector<std::uint32_t> first = firstAtSamePlace(metres->metres);
  for (std::uint32_t v = 0; v < first.size(); ++v) report.verticesWelded += first[v] != v ? 1 : 0;

  OrderedMesh made = ordered(metres->metres, triangles, first);
  result.mesh = std::move(made.mesh);
  result.source = std::move(made.source);
  if (result.mesh.triangles.empty()) return refused("", "no triangle has area; nothing could be felt");
  describeTopology(result.mesh, report);
  closeCracks(result);
  if (result.mesh.vertices.size() > kMaxVertices) {
    return refused("", "holds more than " + number(kMaxVertices) + " vertices");
  }
  report.kept = result.mesh.triangles.size();
  report.droppedDegenerate = triangles.size() - report.kept;
  report.verticesUnused =
      report.verticesInFile - report.verticesWelded - report.verticesJoined - result.mesh.vertices.size();
  report.scale_m = scaling->scale;
  report.isUnitKnown = options.unit_m || options.largestExtent_m;
  report.rounding_m = metres->rounding_m;
  return result;
}

}  // namespace haptics
