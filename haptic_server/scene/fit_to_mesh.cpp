#include "haptic_server/scene/fit_to_mesh.h"

#include <algorithm>
#include <array>
#include <limits>

#include "common/interruption/grow.h"
#include "common/mesh/triangle_distance.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {
namespace {

/// Edges of the mesh that a falloff's radius should span: fewer show a dent as a few corners.
constexpr double kEdgesInRadius = 3;

/// Shortest side of a lattice that an edit may give, m (checkLength()).
constexpr double kFlat_m = 1e-9;

/// A flat mesh has no thickness, and a mapping's box needs one.
constexpr double kMinMappingSide_m = 1e-6;

struct Bounds {
  Vec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
};

Bounds boundsOf(const TriMesh& mesh, const Quat& toFrame = Quat(1, 0, 0, 0)) {
  Bounds bounds;
  for (const Vec3f& vertex : mesh.vertices) {
    const Vec3 at = toFrame * Vec3(vertex);
    bounds.low = glm::min(bounds.low, at);
    bounds.high = glm::max(bounds.high, at);
  }
  return bounds;
}

std::array<Vec3, 3> corners(const std::vector<Vec3f>& vertices, const TriangleIndices& t) {
  return {Vec3(vertices[t[0]]), Vec3(vertices[t[1]]), Vec3(vertices[t[2]])};
}

}  // namespace

std::optional<Error> fitToMesh(DeformationProperties& properties, const TriMesh& mesh, bool latticeOfMesh) {
  if (!properties.softness && !properties.lattice) return std::nullopt;
  const auto [low, high] = boundsOf(mesh);
  const Vec3 size = high - low;
  if (properties.softness) {
    const double longest_m = std::max({size.x, size.y, size.z});
    if (properties.softness->radius_m > longest_m) {
      return Error{"softness.radius_m", "is " + millimetres(properties.softness->radius_m) +
                                            ", beyond the object, whose longest side is " + millimetres(longest_m)};
    }
  }
  const double farthest_m = std::max({-low.x, -low.y, -low.z, high.x, high.y, high.z});
  if (properties.softness && properties.softness->plastic > 0 && farthest_m > double(MovedVertices::kMaxMoved_m)) {
    return Error{
        "softness.plastic",
        "is above 0, and the mesh reaches beyond 1000 m from the object's origin, where no dent is kept: give 0, or "
        "scale the mesh"};
  }
  if (!properties.lattice) return std::nullopt;
  Lattice& lattice = *properties.lattice;
  if (latticeOfMesh) {
    if (std::min({size.x, size.y, size.z}) < kFlat_m) {
      return Error{"lattice.size_m", "is missing, and the box of the mesh is flat; give low_m and size_m"};
    }
    lattice.low_m = low;
    lattice.size_m = size;
  }
  // The box's far corner is rounded when it is given by its size.
  const Vec3 slack = lattice.size_m * 1e-6;
  const Vec3 top = lattice.low_m + lattice.size_m;
  if (glm::any(glm::lessThan(low, lattice.low_m - slack)) || glm::any(glm::greaterThan(high, top + slack))) {
    return Error{"lattice.low_m",
                 "and size_m make a box that the mesh is not within; leave both out for the mesh's own"};
  }
  return std::nullopt;
}

std::size_t flattenedBy(const Lattice& lattice, const TriMesh& mesh) {
  const std::vector<Vec3f> shaped = shapedBy(lattice, mesh.vertices);
  std::size_t flattened = 0;
  forEach(mesh.triangles.size(), [&](std::size_t i) {
    const TriangleIndices& t = mesh.triangles[i];
    if (areaNormal(corners(shaped, t)) == Vec3(0) && areaNormal(corners(mesh.vertices, t)) != Vec3(0)) ++flattened;
  });
  return flattened;
}

std::vector<std::string> deformationWarnings(const DeformationProperties& properties, const TriMesh& mesh,
                                             std::optional<std::size_t> flattened) {
  std::vector<std::string> warnings;
  if (properties.softness) {
    const double edge_m = meanEdge_m(mesh);
    if (properties.softness->radius_m < kEdgesInRadius * edge_m) {
      warnings.push_back("softness.radius_m is less than " + std::to_string(static_cast<int>(kEdgesInRadius)) +
                         " edges of the mesh, which are " + millimetres(edge_m) +
                         " in the mean: dents are coarse, and hard between its vertices");
    }
  }
  if (properties.lattice) {
    const std::size_t flat = flattened ? *flattened : flattenedBy(*properties.lattice, mesh);
    if (flat > 0) warnings.push_back("the lattice leaves " + std::to_string(flat) + " triangles without an area");
  }
  return warnings;
}

void fitToMesh(const MappedSource& source, const TriMesh& mesh, Mapping& mapping) {
  if (!source.centreOfMesh && !source.sizeOfMesh) return;
  const auto [low, high] = boundsOf(mesh, glm::conjugate(mapping.rotation));
  if (source.centreOfMesh) mapping.centre = mapping.rotation * ((low + high) / 2.0);
  if (source.sizeOfMesh) mapping.size_m = glm::max(high - low, Vec3(kMinMappingSide_m));
}

}  // namespace haptics
