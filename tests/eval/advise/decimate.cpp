#include "tests/eval/advise/decimate.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

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

}  // namespace haptics::eval
