#include <limits>
#include <random>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "mesh_files.h"

namespace haptics::import_stl_test {
namespace {

using fixture::raw;
using fixture::tetrahedron;
using ::testing::HasSubstr;

using ImportStl = fixture::MeshFiles;

std::string binaryStl(const TriMesh& mesh, std::string comment = "") {
  comment.resize(80);
  std::string stl = comment + raw(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    stl += std::string(12, '\0');
    for (const std::uint32_t v : triangle) stl += raw(mesh.vertices[v]);
    stl += std::string(2, '\0');
  }
  return stl;
}

std::string textStl(const TriMesh& mesh) {
  std::ostringstream stl;
  stl << "solid a loop\n";
  for (const auto& triangle : mesh.triangles) {
    stl << " facet normal 0 0 1\n  outer loop\n";
    for (const std::uint32_t v : triangle) {
      stl << "   vertex " << mesh.vertices[v].x << ' ' << mesh.vertices[v].y << ' ' << mesh.vertices[v].z << '\n';
    }
    stl << "  endloop\n endfacet\n";
  }
  stl << "endsolid a loop\n";
  return stl.str();
}

TEST_F(ImportStl, WeldsBinaryAndTextToTheSameMesh) {
  for (const std::string& stl :
       {binaryStl(tetrahedron()), binaryStl(tetrahedron(), "solid but binary"), textStl(tetrahedron())}) {
    const auto imported = import("t.stl", stl);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron());
    EXPECT_TRUE(imported->report.closed());
    EXPECT_EQ(imported->report.verticesInFile, 12U);
    EXPECT_EQ(imported->report.verticesWelded, 8U);
  }
}

TEST_F(ImportStl, SaysWithWhatTextBeginsThatIsNone) {
  for (const std::string begin : {"<!DOCTYPE html>", "version https://git-lfs.github.com/spec/v1", "v 0 0 0"}) {
    EXPECT_THAT(refusal("t.stl", begin + "\n" + std::string(200, 'x') + "\n"),
                HasSubstr("is no STL: it is text that begins with \"" + begin.substr(0, 15)));
  }
}

TEST_F(ImportStl, WeldsNothingThatIsApart) {
  TriMesh mesh = *makeSphere(1e-6, 12);  // edges of 0.1 micrometres
  EXPECT_EQ(import("t.stl", binaryStl(mesh))->mesh, mesh);
  for (Vec3f& v : mesh.vertices) v *= 1e-25F;
  EXPECT_EQ(import("t.stl", binaryStl(mesh))->mesh, mesh);
}

TEST_F(ImportStl, ReadsSeveralSolidsInOneFile) {
  TriMesh apart = tetrahedron();
  for (Vec3f& v : apart.vertices) v += 2.0F;
  EXPECT_EQ(import("t.stl", textStl(tetrahedron()) + textStl(apart))->report.kept, 8U);
}

TEST_F(ImportStl, RefusesACountThatTheLengthDoesNotBear) {
  TriMesh open = tetrahedron();
  open.triangles.pop_back();
  const std::string good = binaryStl(open);
  for (const std::uint32_t count : {4U, 300'000'000U, std::numeric_limits<std::uint32_t>::max()}) {
    std::string bad = count > 4 ? good + 'x' : good;
    bad.replace(80, 4, raw(count));
    EXPECT_THAT(refusal("t.stl", bad), HasSubstr("claims " + std::to_string(count) + " triangles")) << count;
  }
  EXPECT_THAT(refusal("t.stl", binaryStl({}).substr(0, 84)), HasSubstr("no face"));
}

TEST_F(ImportStl, IgnoresACountThatWasNotFilledIn) {
  const std::string good = binaryStl(tetrahedron());
  for (const std::uint32_t count : {0U, 1U, 3U, std::numeric_limits<std::uint32_t>::max()}) {
    std::string open = good;
    open.replace(80, 4, raw(count));
    const auto imported = import("t.stl", open);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron());
    EXPECT_THAT(imported->report.text(), HasSubstr("1 wrong count of triangles ignored"));
    EXPECT_EQ(import("t.stl", good)->report.countsIgnored, 0U);
  }
}

TEST_F(ImportStl, TakesWhatIsClosedForWhole) {
  std::string binary = binaryStl(tetrahedron());
  binary.replace(80, 4, raw(5U));
  const std::string text = textStl(tetrahedron());
  for (const std::string& stl : {binary, text.substr(0, text.find("endsolid"))}) {
    const auto imported = import("t.stl", stl);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron());
  }
  std::string big = binaryStl(tetrahedron());
  big.replace(80, 4, raw(0x04000000U));
  EXPECT_THAT(refusal("t.stl", big), HasSubstr("big-endian"));
}

TEST_F(ImportStl, TakesFacetsOfAnyShapeAndLeavesOutLinesInThem) {
  const std::string quad = "vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n";
  for (const std::string& facet :
       {"facet normal 0 0 1\nouter loop\n" + quad + "endloop\nendfacet\n", "facet normal 0 0 1\n" + quad + "endfacet\n",
        "facet\nouter loop\n" + quad + "endloop\n", "facet normal 0 0 1\ncolor 1 0 0\nouter loop\n" + quad}) {
    const auto imported = import("t.stl", "solid\n" + facet + "endsolid\n");
    ASSERT_TRUE(imported) << facet << imported.error().text();
    EXPECT_EQ(imported->report.kept, 2U) << facet;
    EXPECT_EQ(imported->report.linesSkipped, facet.find("color") == facet.npos ? 0U : 1U);
  }
  EXPECT_THAT(
      refusal("t.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertx 1 0 0\nvertex 1 1 0\nendloop\n"),
      HasSubstr("line 7: triangle 0 (from 0) has 2 lines \"vertex\""));
}

TEST_F(ImportStl, LeavesOutWhatFollowsTheLastTriangle) {
  for (const std::size_t size : {1U, 49U, 50U, 1000U}) {
    const auto imported = import("t.stl", binaryStl(tetrahedron()) + std::string(size, 'x'));
    EXPECT_EQ(imported->mesh, tetrahedron());
    EXPECT_EQ(imported->report.bytesAtEnd, size);
    EXPECT_EQ(import("t.stl", binaryStl(tetrahedron()) + std::string(size, '\0'))->report.bytesAtEnd, size);
    EXPECT_THAT(imported->report.text(), HasSubstr(std::to_string(size) + " bytes after the last triangle"));
  }
}

TEST_F(ImportStl, RefusesAFileThatIsCutOffAnywhere) {
  const std::string binary = binaryStl(tetrahedron());
  for (std::size_t size = 1; size < binary.size(); ++size) {
    EXPECT_NE(refusal("t.stl", binary.substr(0, size)), "loaded") << size;
  }
  const std::string text = textStl(tetrahedron());
  for (std::size_t size = 1; size < text.rfind("endloop"); ++size) {
    EXPECT_NE(refusal("t.stl", text.substr(0, size)), "loaded") << size;
  }
}

TEST_F(ImportStl, CountsTrianglesWithCornersAtOnePlace) {
  TriMesh mesh = tetrahedron();
  mesh.triangles.push_back({0, 1, 1});
  for (const std::string& stl : {binaryStl(mesh), textStl(mesh)}) {
    const auto imported = import("t.stl", stl);
    EXPECT_EQ(imported->report.trianglesInFile, 5U);
    EXPECT_EQ(imported->report.droppedDegenerate, 1U);
    EXPECT_EQ(imported->mesh, tetrahedron());
  }
}

TEST_F(ImportStl, NamesTheVertexThatIsNotFinite) {
  TriMesh mesh = tetrahedron();
  mesh.vertices[3].z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal("t.stl", binaryStl(mesh)), HasSubstr("vertex 5 (from 0) is not finite"));
  EXPECT_THAT(refusal("t.stl", textStl(mesh)), HasSubstr("vertex 5 (from 0) is not finite"));
}

TEST_F(ImportStl, ThatIsDamagedIsRefusedOrReportedButNeverFails) {
  std::mt19937 random(13);
  for (const std::string& good : {textStl(tetrahedron()), binaryStl(tetrahedron())}) {
    for (int round = 0; round < 150; ++round) {
      std::string bad = good;
      for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<char>(random());
      const auto imported = import("t.stl", bad);
      if (imported) {
        EXPECT_TRUE(checkMesh(imported->mesh));
      }
    }
  }
}

}  // namespace
}  // namespace haptics::import_stl_test
