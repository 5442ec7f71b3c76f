#include "common/mesh/import.h"

#include <sys/stat.h>

#include <random>

#include "common/mesh/mesh_asset.h"
#include "mesh_files.h"

namespace haptics::import_test {
namespace {

using fixture::kTetrahedronOff;
using fixture::tetrahedron;
using ::testing::HasSubstr;

using Import = fixture::MeshFiles;
using ImportObj = fixture::MeshFiles;
using ImportOff = fixture::MeshFiles;

constexpr std::string_view kTetrahedronObj =
    "# a comment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST_F(Import, ReadsEveryTextFormatToTheSameMesh) {
  EXPECT_EQ(import("t.obj", kTetrahedronObj)->mesh, tetrahedron());
  EXPECT_EQ(import("t.off", kTetrahedronOff)->mesh, tetrahedron());
  EXPECT_EQ(import("T.OFF", kTetrahedronOff)->mesh, tetrahedron());
}

TEST_F(Import, AppliesTheUnit) {
  const auto imported = import("t.off", kTetrahedronOff, {.unit_m = 0.001});
  EXPECT_EQ(imported->report.scale_m, 0.001);
  EXPECT_EQ(imported->mesh.vertices[1], Vec3f(0, 0.001F, 0));
}

TEST_F(Import, RefusesAWrongUnitByItsOwnName) {
  EXPECT_EQ(import("t.off", kTetrahedronOff, {.unit_m = -1}).error().field, "unit_m");
}

TEST_F(Import, RefusesAFormatThatItDoesNotKnow) {
  EXPECT_THAT(refusal("t.xyz", "1 2 3"), HasSubstr("unknown format"));
  EXPECT_THAT(refusal("t", "1 2 3"), HasSubstr(".obj, .ply, .stl, .off, .om or .iv"));
}

TEST_F(Import, OfADamagedTextFileIsRefusedOrReportedButNeverFails) {
  std::mt19937 random(7);
  for (const auto& [name, good] :
       {std::pair<std::string, std::string_view>{"t.obj", kTetrahedronObj}, {"t.off", kTetrahedronOff}}) {
    for (int round = 0; round < 150; ++round) {
      std::string bad(good.substr(0, round % 3 == 0 ? random() % good.size() : good.size()));
      for (int k = 0; k < 3 && !bad.empty(); ++k) bad[random() % bad.size()] = static_cast<char>(random());
      const auto imported = import(name, bad);
      if (imported) {
        EXPECT_TRUE(checkMesh(imported->mesh));
      }
    }
  }
}

TEST_F(ImportObj, TakesTheVertexOfEachCornerCountedFromEitherEnd) {
  const std::string positions = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
  const TriMesh expected = import("t.obj", positions + "f 1 2 3\n")->mesh;
  for (const std::string face :
       {"f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -3 -2 -1", "  f\t1 2 3 # x"}) {
    EXPECT_EQ(import("t.obj", positions + face + "\r\n")->mesh, expected) << face;
  }
  EXPECT_EQ(import("t.obj", "f 1 2 3\n" + positions)->mesh, expected);
}

TEST_F(ImportObj, TriangulatesAndCountsPolygons) {
  const auto imported = import("t.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_EQ(imported->report.polygonsTriangulated, 1U);
  EXPECT_EQ(imported->report.trianglesInFile, 2U);
  EXPECT_EQ(imported->mesh.triangles.size(), 2U);
}

TEST_F(ImportObj, CutsAnOutlineThatNamesVerticesTwiceRoundItsHole) {
  const auto imported = import("t.obj",
                               "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n"
                               "f 1 2 3 4 1 5 8 7 6 5\n");
  EXPECT_EQ(imported->report.kept, 8U);
  EXPECT_EQ(imported->report.boundaryEdges, 8U);
}

TEST_F(ImportObj, CountsEveryFaceThatItCannotUse) {
  const std::string good(kTetrahedronObj);
  const auto imported =
      import("t.obj", good + "f 1 2 5\nf 0 1 2\nf -9 1 2\nf 1 2 99999999999 4\nf 1 2\nf 1 1 2\nf 1 2 2 3\n");
  const MeshReport& report = imported->report;
  EXPECT_EQ(report.droppedOutOfRange, 5U);
  EXPECT_EQ(report.droppedDegenerate, 3U);  // f 1 2; f 1 1 2; half of f 1 2 2 3
  EXPECT_EQ(report.kept, 5U);
  EXPECT_EQ(report.trianglesInFile, 13U);
  EXPECT_EQ(report.duplicateFaces, 1U);
}

TEST_F(ImportObj, NamesTheVertexOrLineThatIsWrong) {
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("vertex 1 (from 0) is not finite"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("vertex 1 (from 0) is not finite"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 1e39 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("vertex 1 (from 0) does not fit"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 0\n"), HasSubstr("vertex 1 (from 0) has fewer than three coordinates"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 1,5\n"), HasSubstr("\"1,5\" where a number should be"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nf 1 /2 3\n"), HasSubstr("line 2: \"/2\""));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), HasSubstr("no face"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), HasSubstr("1 name a vertex that is not there"));
}

TEST_F(ImportObj, OpensNoOtherFile) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);  // opening it would wait for ever
  const std::string reference = "mtllib " + (folder_ / "pipe").string() + "\nmtllib pipe\nusemtl x\n";
  EXPECT_EQ(import("t.obj", reference + std::string(kTetrahedronObj))->mesh, tetrahedron());
}

TEST_F(ImportObj, KeepsFacesAtNonManifoldEdges) {
  const auto imported = import("t.obj", std::string(kTetrahedronObj) + "v 5 5 5\nf 1 2 5\n");
  EXPECT_EQ(imported->report.kept, 5U);
  EXPECT_EQ(imported->report.nonManifoldEdges, 1U);
  EXPECT_EQ(imported->mesh.vertices.size(), 5U);
}

TEST_F(ImportOff, SkipsCommentsAnywhere) {
  EXPECT_EQ(import("t.off",
                   "# made by hand\n\nOFF # geometry\n# counts\n4 4 6\n0 0 0 # first\n1 0 0\n0 1 0\n\n0 0 1\n"
                   "3 0 2 1\n# half way\n3 0 1 3 255 0 0\n3 1 2 3\n3 2 0 3\n# end")
                ->mesh,
            tetrahedron());
}

TEST_F(ImportOff, LeavesOutColoursAndNormals) {
  EXPECT_EQ(import("t.off",
                   "STCNOFF 4 4 6\n0 0 0 0 0 1 9 9 9 9 0 0\n1 0 0 0 0 1 9 9 9 9 0 0\n0 1 0 0 0 1 9 9 9 9 0 0\n"
                   "0 0 1 0 0 1 9 9 9 9 0 0\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
                ->mesh,
            tetrahedron());
}

TEST_F(ImportOff, RefusesAHeaderThatClaimsMoreThanTheFileHolds) {
  EXPECT_THAT(refusal("t.off", "OFF\n300000000 1 0\n0 0 0\n"), HasSubstr("claims 300000000 vertices"));
  EXPECT_THAT(refusal("t.off", "OFF\n1 4000000000 0\n0 0 0\n"), HasSubstr("4000000000 faces"));
  EXPECT_THAT(refusal("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"), HasSubstr("face 0 (from 0)"));
  EXPECT_THAT(refusal("t.off", "OFF\n-3 1 0\n"), HasSubstr("number of vertices"));
}

TEST_F(ImportOff, RefusesAFileThatIsCutOff) {
  const std::string_view whole = kTetrahedronOff;
  const std::size_t lastLine = whole.rfind('3', whole.size() - 8);
  for (std::size_t size = 1; size < lastLine; ++size) {
    EXPECT_NE(refusal("t.off", whole.substr(0, size)), "loaded") << whole.substr(0, size);
  }
  EXPECT_THAT(refusal("t.off", whole.substr(0, lastLine)), HasSubstr("ends after 3 of 4 faces"));
}

TEST_F(ImportOff, NamesTheVertexOrFaceThatIsWrong) {
  EXPECT_THAT(refusal("t.off", "OFF\n3 1 0\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n"), HasSubstr("vertex 1 (from 0)"));
  EXPECT_THAT(refusal("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 10 11\n"), HasSubstr("face 0 (from 0) has fewer"));
  EXPECT_THAT(refusal("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 x\n"),
              HasSubstr("line 6: \"x\" where a number should be"));
  EXPECT_THAT(refusal("t.off", "PNG\n"), HasSubstr("begins with \"PNG\""));
  EXPECT_THAT(refusal("t.off", "OFF BINARY\n"), HasSubstr("binary OFF"));
}

TEST_F(ImportOff, CountsFacesThatNameVerticesThatAreNotThere) {
  const auto imported = import("t.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n4 0 1 2 4\n2 0 1\n");
  EXPECT_EQ(imported->report.droppedOutOfRange, 2U);
  EXPECT_EQ(imported->report.droppedDegenerate, 1U);
  EXPECT_EQ(imported->report.verticesUnused, 1U);
}

}  // namespace
}  // namespace haptics::import_test
