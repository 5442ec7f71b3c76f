#include "common/mesh/topology.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <vector>

#include "common/maths/elementary.h"
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

/// The parts of a mesh: vertices that triangles join, directly or through others.
class Parts {
 public:
  explicit Parts(const TriMesh& mesh) : mesh_(mesh), of_(mesh.vertices.size()), parts_(mesh.vertices.size()) {
    std::iota(of_.begin(), of_.end(), 0U);
    for (const auto [a, b, c] : mesh.triangles) join(a, b), join(b, c);
    for (const auto [a, b, c] : mesh.triangles) {
      Part& part = parts_[find(a)];
      if (part.triangles++ == 0) part.origin = Vec3(mesh.vertices[a]);
      const Vec3 p = at(a) - part.origin, q = at(b) - part.origin, r = at(c) - part.origin;
      part.volume_m3 += glm::dot(p, glm::cross(q, r)) / 6;
      part.size_m3 += std::abs(glm::dot(p, glm::cross(q, r))) / 6;
    }
  }

  void open(std::uint32_t vertex) { parts_[find(vertex)].closed = false; }

  void describe(MeshReport& report) {
    for (std::uint32_t v = 0; v < of_.size(); ++v) {
      const Part& part = parts_[v];
      if (part.triangles == 0 || !part.closed) continue;
      ++report.closedParts;
      if (part.volume_m3 < -kFlat * part.size_m3 && !isHollow(v)) ++report.insideOutParts;
    }
  }

 private:
  static constexpr double kFlat = 1e-6;  // of what its faces enclose with one of its vertices: no inside
  struct Part {
    std::uint64_t triangles = 0;
    bool closed = true;
    Vec3 origin{0};
    double volume_m3 = 0, size_m3 = 0;
  };

  [[nodiscard]] Vec3 at(std::uint32_t vertex) const { return Vec3(mesh_.vertices[vertex]); }
  std::uint32_t find(std::uint32_t v) {
    while (of_[v] != v) v = of_[v] = of_[of_[v]];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) { of_[find(b)] = find(a); }

  /// Do other parts wind around it? By the solid angles of their triangles (van Oosterom and Strackee 1983).
  [[nodiscard]] bool isHollow(std::uint32_t part) {
    // Triangles looked at for all parts; further parts count as hollows.
    constexpr std::uint64_t kMaxLooked = 20'000'000;
    looked_ += mesh_.triangles.size();
    if (looked_ > kMaxLooked + mesh_.triangles.size()) return true;
    const Vec3 from = parts_[part].origin;
    double half = 0;
    for (const auto [a, b, c] : mesh_.triangles) {
      if (find(a) == part) continue;
      const Vec3 p = at(a) - from, q = at(b) - from, r = at(c) - from;
      const double pl = glm::length(p), ql = glm::length(q), rl = glm::length(r);
      half += elementary::atan2(glm::dot(p, glm::cross(q, r)),
                                pl * ql * rl + glm::dot(p, q) * rl + glm::dot(q, r) * pl + glm::dot(r, p) * ql);
    }
    return half > std::numbers::pi;  // of 2 pi for once around
  }

  const TriMesh& mesh_;
  std::vector<std::uint32_t> of_;
  std::vector<Part> parts_;
  std::uint64_t looked_ = 0;
};

void describeEdges(const TriMesh& mesh, MeshReport& report) {
  std::vector<std::uint64_t> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const auto [a, b, c] : mesh.triangles) {
    sides.insert(sides.end(), {sideKey(a, b), sideKey(b, c), sideKey(c, a)});
  }
  std::sort(sides.begin(), sides.end());

  Parts parts(mesh);
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
    const bool inconsistent = faces == 2 && sides[i] == sides[i + 1];
    if (inconsistent) ++report.inconsistentEdges;
    if (faces != 2 || inconsistent) parts.open(ends[0]);
    length += glm::distance(Vec3(mesh.vertices[ends[0]]), Vec3(mesh.vertices[ends[1]]));
    i = end;
  }
  report.meanEdge_m = length / static_cast<double>(edges);
  report.boundaryEdges = boundary.size();
  parts.describe(report);
  Work work = tJunctionAllowance(boundary.size());
  const auto tJunctions = countTJunctions(mesh.vertices, boundary, work);
  report.tJunctions = tJunctions.value_or(0);
  report.tJunctionsSearched = tJunctions.has_value();
}

/// A sliver's longest side is this many times as long as it is high.
constexpr double kNeedle = 1000;

bool isSliver(Vec3 a, Vec3 b, Vec3 c) {
  const double longest2 = std::max({squaredLength(b - a), squaredLength(c - b), squaredLength(a - c)});
  return glm::length(glm::cross(b - a, c - a)) * kNeedle < longest2;
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
  report.closedParts = report.insideOutParts = 0;
  describeEdges(mesh, report);
  countDuplicates(mesh, report);
  describeFaces(mesh, report);
  report.boxMin_m = report.boxMax_m = mesh.vertices.front();
  for (const Vec3f v : mesh.vertices) {
    report.boxMin_m = glm::min(report.boxMin_m, Vec3(v));
    report.boxMax_m = glm::max(report.boxMax_m, Vec3(v));
  }
}

double MeshReport::longestSide_m() const noexcept {
  const Vec3 size_m = boxMax_m - boxMin_m;
  return std::max({size_m.x, size_m.y, size_m.z});
}

std::optional<ImportOptions> likelyScale(double longestSide_m) {
  constexpr double kMillimetre_m = 1e-3;
  if (longestSide_m <= kLargest_m) return std::nullopt;
  if (longestSide_m * kMillimetre_m <= kLargest_m) return ImportOptions{.unit_m = kMillimetre_m};
  return ImportOptions{.largestExtent_m = kScaledTo_m};
}

std::string MeshReport::doubtOfUnit() const {
  const auto scale = isUnitKnown ? std::nullopt : likelyScale(longestSide_m());
  if (!scale) return "";
  char doubt[100];
  std::snprintf(doubt, sizeof doubt, "%.4g m large; did you mean %s: %g?", longestSide_m(),
                scale->unit_m ? "unit_m" : "largest_extent_m",
                scale->unit_m.value_or(scale->largestExtent_m.value_or(0)));
  return doubt;
}

std::string MeshReport::text() const {
  std::string line = std::to_string(kept) + " of " + std::to_string(trianglesInFile) + " triangles kept";
  const auto mention = [&line](std::uint64_t count, const char* label) {
    if (count > 0) line += ", " + std::to_string(count) + ' ' + label;
  };
  mention(polygonsTriangulated, "polygons cut into triangles");
  mention(polygonsCrossing, "of them cross themselves, and have triangles that face back");
  mention(shapesSkipped,
          "parts skipped (NURBS, splines, texts, lines, points, unknown nodes, or other files that are not read)");
  mention(meshesTaken > 1 ? meshesTaken : 0, "meshes of the file as one");
  mention(meshesLeft, "meshes of the file that were not asked for");
  mention(leftOut.points, "points left out");
  mention(leftOut.lines, "lines left out");
  mention(leftOut.skins, "meshes with a skin, as stored and not as posed");
  mention(leftOut.morphs, "meshes with morph targets, as stored");
  mention(leftOut.animations, "animations left out");
  mention(leftOut.unshown, "meshes left out that the scene does not show");
  mention(leftOut.instances, "copies of meshes left out that EXT_mesh_gpu_instancing places");
  mention(headerLinesSkipped, "header lines skipped that begin with no keyword");
  mention(linesSkipped, "lines, or ends of lines, skipped that the format does not have");
  mention(bytesAtEnd, "bytes after the last triangle left out");
  mention(countsIgnored, "wrong count of triangles ignored, the file's length says how many there are");
  mention(droppedDegenerate, "degenerate triangles dropped");
  mention(droppedOutOfRange, "triangles dropped for naming a vertex that is not there");
  mention(duplicateFaces, "duplicate faces kept");
  mention(verticesWelded, "vertices welded");
  mention(verticesJoined, "vertices joined that only rounding kept apart");
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
  if (insideOutParts > 0) {
    line +=
        insideOutParts == closedParts && closedParts == 1
            ? ", inside out"
            : ", " + std::to_string(insideOutParts) + " of " + std::to_string(closedParts) + " closed parts inside out";
    line += " and felt from within alone (turn the faces over, unless it is a room)";
  }
  const Vec3 size_mm = (boxMax_m - boxMin_m) * 1e3;
  char sizes[160];
  std::snprintf(sizes, sizeof sizes, ", largest valence %u, mean edge %.3g mm, size %.4g x %.4g x %.4g mm, scale %.4g",
                maxValence, meanEdge_m * 1e3, size_mm.x, size_mm.y, size_mm.z, scale_m);
  line += sizes;
  if (const std::string doubt = doubtOfUnit(); !doubt.empty()) line += ", " + doubt;
  constexpr double kTellRounding = 1e-6;  // of the size
  if (rounding_m * 1e3 > kTellRounding * std::max({size_mm.x, size_mm.y, size_mm.z})) {
    char rounding[200];
    std::snprintf(rounding, sizeof rounding,
                  ", so far from the origin that float32 puts vertices up to %.2g mm off (give largest_extent_m, which "
                  "centres the mesh, and a file that holds float64: OBJ, or PLY of doubles)",
                  rounding_m * 1e3);
    line += rounding;
  }
  return line;
}

}  // namespace haptics
