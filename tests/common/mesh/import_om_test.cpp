#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <random>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "mesh_files.h"

namespace haptics::import_om_test {
namespace {

using fixture::raw;
using ::testing::HasSubstr;

using OpenMeshMesh = OpenMesh::PolyMesh_ArrayKernelT<>;

class ImportOm : public fixture::MeshFiles {
 protected:
  /// The file that OpenMesh writes, with every attribute that it can write.
  std::string omFile(const TriMesh& mesh, bool attributes) const {
    OpenMeshMesh written;
    for (const Vec3f v : mesh.vertices) written.add_vertex({v.x, v.y, v.z});
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto corner = [](std::uint32_t v) { return OpenMesh::VertexHandle(static_cast<int>(v)); };
      written.add_face(corner(a), corner(b), corner(c));
    }
    return bytesOf(written, attributes);
  }

  std::string bytesOf(OpenMeshMesh& mesh, bool attributes) const {
    OpenMesh::IO::Options options = OpenMesh::IO::Options::Binary;
    if (attributes) {
      mesh.request_vertex_normals();
      mesh.request_face_normals();
      mesh.request_vertex_colors();
      mesh.request_vertex_status();
      mesh.request_edge_status();
      mesh.request_face_status();
      mesh.request_halfedge_status();
      mesh.update_normals();
      OpenMesh::VPropHandleT<double> weight;
      mesh.add_property(weight, "weight");
      mesh.property(weight).set_persistent(true);
      options += OpenMesh::IO::Options::VertexNormal;
      options += OpenMesh::IO::Options::FaceNormal;
      options += OpenMesh::IO::Options::VertexColor;
      options += OpenMesh::IO::Options::Status;
      options += OpenMesh::IO::Options::Custom;
    }
    EXPECT_TRUE(OpenMesh::IO::write_mesh(mesh, (folder_ / "written.om").string(), options));
    std::ifstream file(folder_ / "written.om", std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(ImportOm, ReadsWhatOpenMeshWrites) {
  const TriMesh sphere = *makeSphere(0.05, 6);
  for (const bool attributes : {false, true}) {
    const auto imported = import("t.om", omFile(sphere, attributes));
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_TRUE(imported->report.closed());
    EXPECT_EQ(imported->report.kept, sphere.triangles.size());
    const TriMesh& mesh = imported->mesh;
    ASSERT_EQ(mesh.vertices.size(), sphere.vertices.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::vector<Vec3f> ours, theirs;
      for (std::size_t k = 0; k < 3; ++k) {
        ours.push_back(mesh.vertices[mesh.triangles[t][k]]);
        theirs.push_back(sphere.vertices[sphere.triangles[t][k]]);
      }
      EXPECT_THAT(ours, ::testing::UnorderedElementsAreArray(theirs));
    }
  }
}

TEST_F(ImportOm, TriangulatesPolygons) {
  OpenMeshMesh quad;
  std::vector<OpenMesh::VertexHandle> corners;
  for (const auto& p : {OpenMesh::Vec3f(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})
    corners.push_back(quad.add_vertex(p));
  quad.add_face(corners);
  const auto imported = import("t.om", bytesOf(quad, false));
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.polygonsTriangulated, 1U);
  EXPECT_EQ(imported->report.kept, 2U);
}

TEST_F(ImportOm, ReadsTheFirstVersionOfTheFormat) {
  const auto chunk = [](unsigned entity, unsigned type, unsigned isFloat, unsigned dimension, unsigned bits) {
    return raw(
        static_cast<std::uint16_t>(entity << 2 | type << 5 | isFloat << 10 | (dimension - 1) << 11 | bits << 14));
  };
  std::string om = "OMT" + raw(static_cast<std::uint8_t>(1 << 5 | 2));
  for (const std::uint32_t count : {4U, 4U, 6U}) om += raw(count);
  om += chunk(0, 0, 1, 3, 0);
  for (const Vec3f v : {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, 1)}) om += raw(v);
  om += chunk(2, 7, 0, 1, 0) + std::string("\0\2\1\0\1\3\1\2\3\2\0\3", 12);
  const auto imported = import("t.om", om);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, fixture::tetrahedron());
}

TEST_F(ImportOm, RefusesAFileThatIsCutOffAnywhere) {
  const std::string om = omFile(fixture::tetrahedron(), false);
  for (std::size_t size = 1; size + sizeof(std::uint16_t) < om.size(); ++size) {
    EXPECT_NE(refusal("t.om", om.substr(0, size)), "loaded") << size << " of " << om.size();
  }
}

TEST_F(ImportOm, RefusesAHeaderThatClaimsMoreThanTheFileHolds) {
  const std::string good = omFile(fixture::tetrahedron(), false);
  for (const std::size_t at : {4U, 8U, 12U}) {
    for (const std::uint32_t count : {300'000'000U, 0xFFFFFFFFU}) {
      std::string bad = good;
      bad.replace(at, 4, raw(count));
      EXPECT_NE(refusal("t.om", bad), "loaded") << at << ' ' << count;
    }
  }
}

TEST_F(ImportOm, NamesTheVertexThatIsNotFinite) {
  TriMesh mesh = fixture::tetrahedron();
  mesh.vertices[2].x = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusal("t.om", omFile(mesh, false)), HasSubstr("vertex 2 (from 0) is not finite"));
}

TEST_F(ImportOm, ThatIsDamagedIsRefusedOrReportedButNeverFails) {
  std::mt19937 random(17);
  for (const bool attributes : {false, true}) {
    const std::string good = omFile(fixture::tetrahedron(), attributes);
    for (int round = 0; round < 200; ++round) {
      std::string bad = good;
      for (int k = 0; k < 2; ++k) bad[random() % bad.size()] = static_cast<char>(random());
      const auto imported = import("t.om", bad);
      if (imported) {
        EXPECT_TRUE(checkMesh(imported->mesh));
      }
    }
  }
}

}  // namespace
}  // namespace haptics::import_om_test
