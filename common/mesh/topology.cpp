#include "common/mesh/topology.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "common/mesh/t_junctions.h"

namespace haptics {
namespace {

// A side of a triangle as one sortable word: smaller vertex, larger vertex, whether it runs from larger to smaller.
constexpr int kVertexBits = 31;
constexpr std::uint64_t kVertexMask = (std::uint64_t{1} << kVertexBits) - 1;
static_assert(kMaxVertices <= kVertexMask);

std::uint64_t sideKey(std::uint32_t from, std::uint32_t to) {
  const std::uint64_t low = std::min(from, to), high = std::max(from, to);
  return low << (kVertexBits + 1) | high << 1 | (from > to ? 1 : 0);
}

void describeEdges(const TriMesh& mesh, MeshReport& report) {
  std::vector<std::uint64_t> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const auto [a, b, c] : mesh.triangles) {
    sides.insert(sides.end(), {sideKey(a, b), sideKey(b, c), sideKey(c, a)});
  }
  std::sort(sides.begin(), sides.end());

  std::vector<EdgeIndices> boundary;
  double length = 0;
  std::uint64_t edges = 0;
  for (std::size_t i = 0; i < sides.size(); ++edges) {
    const std::uint64_t edge = sides[i] >> 1;
    std::size_t end = i;
    while (end < sides.size() && sides[end] >> 1 == edge) ++end;
    const std::size_t faces = end - i;
    const EdgeIndices ends{static_cast<std::uint32_t>(edge >> kVertexBits),
                           static_cast<std::uint32_t>(edge & kVertexMask)};
    if (faces == 1) boundary.push_back(ends);
    if (faces > 2) ++report.nonManifoldEdges;
    if (faces == 2 && sides[i] == sides[i + 1]) ++report.inconsistentEdges;
    length += glm::distance(Vec3(mesh.vertices[ends[0]]), Vec3(mesh.vertices[ends[1]]));
    i = end;
  }
  report.meanEdge_m = length / static_cast<double>(edges);
  report.boundaryEdges = boundary.size();
  Work work = tJunctionAllowance(boundary.size());
  const auto tJunctions = countTJunctions(mesh.vertices, boundary, work);
  report.tJunctions = tJunctions.value_or(0);
  report.tJunctionsSearched = tJunctions.has_value();
}

/// A sliver's longest side is this many times as long as it is high.
constexpr double kSliver = 1000;

bool isSliver(Vec3 a, Vec3 b, Vec3 c) {
  const double longest2 = std::max({squaredLength(b - a), squaredLength(c - b), squaredLength(a - c)});
  return glm::length(glm::cross(b - a, c - a)) * kSliver < longest2;
}

void describeFaces(const TriMesh& mesh, MeshReport& report) {
  std::vector<std::uint32_t> valence(mesh.vertices.size(), 0);
  for (const TriangleIndices& triangle : mesh.triangles) {
    const auto [a, b, c] = triangle;
    if (isSliver(Vec3(mesh.vertices[a]), Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c]))) ++report.slivers;
    for (const std::uint32_t v : triangle) ++valence[v];
  }
  report.maxValence = *std::max_element(valence.begin(), valence.end());
  report.crowdedVertices = static_cast<std::uint64_t>(
      std::count_if(valence.begin(), valence.end(), [](std::uint32_t n) { return n > kCrowdedValence; }));
}

void countDuplicates(const TriMesh& mesh, MeshReport& report) {
  std::vector<TriangleIndices> faces = mesh.triangles;
  for (TriangleIndices& face : faces) std::sort(face.begin(), face.end());
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 1; i < faces.size(); ++i) report.duplicateFaces += faces[i] == faces[i - 1] ? 1 : 0;
}

}  // namespace

void describeTopology(const TriMesh& mesh, MeshReport& report) {
  report.nonManifoldEdges = report.inconsistentEdges = report.duplicateFaces = report.slivers = 0;
  describeEdges(mesh, report);
  countDuplicates(mesh, report);
  describeFaces(mesh, report);
  report.boxMin_m = report.boxMax_m = mesh.vertices.front();
  for (const Vec3f v : mesh.vertices) {
    report.boxMin_m = glm::min(report.boxMin_m, Vec3(v));
    report.boxMax_m = glm::max(report.boxMax_m, Vec3(v));
  }
}

std::string MeshReport::text() const {
  std::string line = std::to_string(kept) + " of " + std::to_string(trianglesInFile) + " triangles kept";
  const auto mention = [&line](std::uint64_t count, const char* label) {
    if (count > 0) line += ", " + std::to_string(count) + ' ' + label;
  };
  mention(polygonsTriangulated, "polygons cut into triangles");
  mention(shapesSkipped, "parts skipped (NURBS, or included files that are not beside it)");
  mention(headerLinesSkipped, "header lines skipped that begin with no keyword");
  mention(bytesAtEnd, "bytes after the last triangle left out");
  mention(droppedDegenerate, "degenerate triangles dropped");
  mention(droppedOutOfRange, "triangles dropped for naming a vertex that is not there");
  mention(duplicateFaces, "duplicate faces kept");
  mention(verticesWelded, "vertices welded");
  mention(verticesUnused, "unused vertices left out");
  mention(boundaryEdges, "boundary edges");
  mention(tJunctions, "of them T-junctions");
  if (!tJunctionsSearched) line += ", not searched for T-junctions, because too many edges pass each other";
  mention(nonManifoldEdges, "non-manifold edges");
  mention(inconsistentEdges, "edges with one face flipped");
  mention(repair.selfIntersections, "pairs of triangles that pass through each other");
  mention(repair.selfIntersectionsLeft, "of them left as they are");
  if (repair.trianglesCut > 0) {
    char cut[120];
    std::snprintf(cut, sizeof cut, ", %llu triangles cut out there and %llu put in their place, %.3g mm off at most",
                  static_cast<unsigned long long>(repair.trianglesCut),
                  static_cast<unsigned long long>(repair.trianglesFilled), repair.farthest_m * 1e3);
    line += cut;
  }
  if (!repair.searched) {
    line += ", not searched for triangles that pass through each other, because too many are in one place";
  }
  if (!repair.finished) line += ", not mended everywhere, because there are too many such places";
  mention(slivers, "slivers");
  mention(crowdedVertices, "vertices with so many faces that a search around them takes several ticks");
  if (closed()) line += ", closed";
  const Vec3 size_mm = (boxMax_m - boxMin_m) * 1e3;
  char sizes[160];
  std::snprintf(sizes, sizeof sizes, ", largest valence %u, mean edge %.3g mm, size %.4g x %.4g x %.4g mm, scale %.4g",
                maxValence, meanEdge_m * 1e3, size_mm.x, size_mm.y, size_mm.z, scale_m);
  return line + sizes;
}

}  // namespace haptics
