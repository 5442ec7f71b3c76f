#include "tests/eval/advise/decimate.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/mesh/import.h"

namespace haptics::eval {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

Mesh halfEdgesOf(const TriMesh& mesh) {
  Mesh halfEdges;
  for (const Vec3f v : mesh.vertices) halfEdges.add_vertex(Mesh::Point(v.x, v.y, v.z));
  for (const TriangleIndices& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) { return OpenMesh::VertexHandle(static_cast<int>(t[k])); };
    halfEdges.add_face(corner(0), corner(1), corner(2));
  }
  halfEdges.request_face_normals();
  halfEdges.update_face_normals();
  return halfEdges;
}

TriMesh triMeshOf(const Mesh& halfEdges) {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> faces;
  for (const auto v : halfEdges.vertices()) {
    const Mesh::Point p = halfEdges.point(v);
    vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto f : halfEdges.faces()) {
    TriangleIndices corners{};
    std::size_t k = 0;
    for (const auto v : f.vertices()) corners[k++] = static_cast<std::uint32_t>(v.idx());
    faces.push_back(corners);
  }
  return canonicalise(vertices, std::move(faces), {}).value().mesh;
}

/// Least height over longest side of the triangles that a half-edge's collapse moves; negative where one of them leaves its
/// plane by more than `most_m`, or turns over.
double shapeAfter(const Mesh& mesh, OpenMesh::SmartHalfedgeHandle collapse, double most_m) {
  constexpr double kBad = -1;
  const auto from = collapse.from();
  const Mesh::Point target = mesh.point(collapse.to());
  double worst = 1;
  for (const auto face : from.faces()) {
    std::array<Mesh::Point, 3> now, then;
    bool goes = false;
    std::size_t k = 0;
    for (const auto v : face.vertices()) {
      goes = goes || v == collapse.to();
      now[k] = mesh.point(v);
      then[k++] = v == from ? target : mesh.point(v);
    }
    const Mesh::Point normal = cross(now[1] - now[0], now[2] - now[0]).normalized();
    if (std::abs(dot(normal, target - now[0])) > most_m) return kBad;
    if (goes) continue;
    const double longest_m = std::sqrt(
        std::max({(then[1] - then[0]).sqrnorm(), (then[2] - then[1]).sqrnorm(), (then[0] - then[2]).sqrnorm()}));
    worst = std::min(worst, dot(cross(then[1] - then[0], then[2] - then[0]), normal) / (longest_m * longest_m));
  }
  return worst;
}

/// The collapse that takes a vertex away and leaves the best shapes; not valid where there is none.
OpenMesh::SmartHalfedgeHandle flatCollapse(Mesh& mesh, OpenMesh::SmartVertexHandle vertex, double most_m) {
  OpenMesh::SmartHalfedgeHandle best;
  double bestShape = 1e-3;
  for (const auto outgoing : vertex.outgoing_halfedges()) {
    if (!mesh.is_collapse_ok(outgoing)) continue;
    const double shape = shapeAfter(mesh, outgoing, most_m);
    if (shape <= bestShape) continue;
    best = outgoing;
    bestShape = shape;
  }
  return best;
}

double longestSide_m(const TriMesh& mesh) {
  Vec3 low(mesh.vertices.front());
  Vec3 high = low;
  for (const Vec3f v : mesh.vertices) {
    low = glm::min(low, Vec3(v));
    high = glm::max(high, Vec3(v));
  }
  const Vec3 size = high - low;
  return std::max({size.x, size.y, size.z});
}

}  // namespace

TriMesh decimated(const TriMesh& mesh, std::size_t triangles) {
  omerr().disable();  // a line for each face that is not manifold
  Mesh halfEdges = halfEdgesOf(mesh);
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(halfEdges);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  decimater.add(flipping);
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  halfEdges.garbage_collection();
  return triMeshOf(halfEdges);
}

TriMesh merged(const TriMesh& mesh) {
  omerr().disable();
  Mesh halfEdges = halfEdgesOf(mesh);
  halfEdges.request_vertex_status();
  halfEdges.request_edge_status();
  halfEdges.request_halfedge_status();
  halfEdges.request_face_status();
  const double most_m = kExact_of_longest * longestSide_m(mesh);
  for (bool goesOn = true; goesOn;) {
    goesOn = false;
    for (const auto vertex : halfEdges.vertices()) {
      if (vertex.is_boundary() || !halfEdges.is_manifold(vertex)) continue;
      const auto collapse = flatCollapse(halfEdges, vertex, most_m);
      if (!collapse.is_valid()) continue;
      halfEdges.collapse(collapse);
      goesOn = true;
    }
  }
  halfEdges.garbage_collection();
  return triMeshOf(halfEdges);
}

}  // namespace haptics::eval
