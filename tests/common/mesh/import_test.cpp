#include "common/mesh/import.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "common/mesh/file_bytes.h"
#include "common/mesh/mesh_asset.h"
#include "mesh_files.h"
#include "tests/common/temporary_folder.h"

namespace haptics::import_test {
namespace {

using fixture::kTetrahedronOff;
using fixture::tetrahedron;
using ::testing::HasSubstr;
using ::testing::Not;

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
  EXPECT_THAT(refusal("t", "1 2 3"), HasSubstr(".x3d or .x3dv, packed in .gz or not"));
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

TEST_F(Import, NamesAnotherEncoding) {
  using namespace std::string_literals;
  for (const std::string name : {"t.obj", "t.off", "t.ply", "t.stl"}) {
    for (const std::string& text : {"\xff\xfev\0 \0"s, "\xfe\xff\0v\0 "s, "v\0 \0"s, "\0v\0 "s}) {
      EXPECT_THAT(refusal(name, text), HasSubstr("is in UTF-16")) << name;
    }
    for (const std::string& text : {"\xff\xfe\0\0v\0\0\0"s, "v\0\0\0 \0\0\0"s, "\0\0\0v\0\0\0 "s}) {
      EXPECT_THAT(refusal(name, text), HasSubstr("is in UTF-32")) << name;
    }
    // Numbers of 16 and 32 bits.
    for (const std::string& bytes : {"f\0\0\0t\1\0\0"s, "f\0t\1"s, "\1\0\0\0\2\0\0\0"s}) {
      EXPECT_THAT(refusal(name, bytes), Not(HasSubstr("UTF"))) << name;
    }
  }
}

/// A prism of 24 sides, radius 0.5 and height 1, away from the origin, in each format that holds float64.
class ImportFarAway : public fixture::MeshFiles {
 protected:
  static constexpr int kSides = 24;

  static Vec3 corner(int i, Vec3 at) {
    const double angle = 2 * std::numbers::pi * (i % kSides) / kSides;
    return at + Vec3(0.5 * std::cos(angle), 0.5 * std::sin(angle), i < kSides ? 0 : 1);
  }
  static std::vector<std::array<int, 3>> triangles() {
    std::vector<std::array<int, 3>> all;
    for (int i = 0; i < kSides; ++i) {
      const int next = (i + 1) % kSides;
      all.push_back({i, next, next + kSides});
      all.push_back({i, next + kSides, i + kSides});
    }
    return all;
  }
  static std::string words(Vec3 v) {
    char text[100];
    std::snprintf(text, sizeof text, "%.10f %.10f %.10f\n", v.x, v.y, v.z);
    return text;
  }

  static std::vector<std::pair<std::string, std::string>> files(Vec3 at) {
    std::string vertices, obj, faces, bytes, list, stl = "solid\n";
    for (int i = 0; i < 2 * kSides; ++i) {
      const Vec3 v = corner(i, at);
      vertices += words(v);
      obj += "v " + words(v);
      bytes += fixture::raw(v.x) + fixture::raw(v.y) + fixture::raw(v.z);
    }
    for (const auto& [a, b, c] : triangles()) {
      const auto number = [](int i) { return ' ' + std::to_string(i); };
      faces += '3' + number(a) + number(b) + number(c) + '\n';
      obj += 'f' + number(a + 1) + number(b + 1) + number(c + 1) + '\n';
      list += '\3' + fixture::raw(a) + fixture::raw(b) + fixture::raw(c);
      stl += "facet normal 0 0 0 outer loop vertex " + words(corner(a, at)) + "vertex " + words(corner(b, at)) +
             "vertex " + words(corner(c, at)) + "endloop endfacet\n";
    }
    const auto ply = [](const std::string& format) {
      return "ply\nformat " + format +
             " 1.0\nelement vertex 48\nproperty double x\nproperty double y\nproperty double z\n"
             "element face 48\nproperty list uchar int vertex_indices\nend_header\n";
    };
    return {{"t.obj", obj},
            {"t.off", "OFF\n48 48 0\n" + vertices + faces},
            {"t.ply", ply("ascii") + vertices + faces},
            {"t.ply", ply("binary_little_endian") + bytes + list},
            {"t.stl", stl + "endsolid\n"}};
  }
};

TEST_F(ImportFarAway, KeepsTheShapeThatIsCentred) {
  for (const Vec3 at :
       {Vec3(0), Vec3(691234.5, 5334567.25, 512), Vec3(4177000.25, 855000.5, 4727000.125), Vec3(-2e7, 7e6, 3)}) {
    for (const auto& [name, file] : files(at)) {
      const auto imported = import(name, file, {.largestExtent_m = 0.1});
      ASSERT_TRUE(imported) << imported.error().text();
      ASSERT_EQ(imported->mesh.vertices.size(), 48U);
      for (const Vec3f& v : imported->mesh.vertices) {
        EXPECT_NEAR(std::hypot(static_cast<double>(v.x), static_cast<double>(v.y)), 0.05, 1e-7) << name;
        EXPECT_NEAR(std::abs(static_cast<double>(v.z)), 0.05, 1e-7) << name;
      }
      EXPECT_THAT(imported->report.text(), Not(HasSubstr("so far from the origin")));
    }
  }
}

TEST_F(ImportFarAway, SaysWhatFloat32LeavesOfIt) {
  const Vec3 utm(691234.5, 5334567.25, 512);
  for (const auto& [name, file] : files(utm)) {
    const auto imported = import(name, file);
    EXPECT_NEAR(imported->report.rounding_m, 0.25, 0.05) << name;
    EXPECT_THAT(imported->report.text(), HasSubstr("so far from the origin that float32 puts vertices up to 2"))
        << name;
  }
  std::string stl(84, '\0');
  stl.replace(80, 4, fixture::raw(48));
  for (const auto& triangle : triangles()) {
    stl += std::string(12, '\0');
    for (const int i : triangle) stl += fixture::raw(Vec3f(corner(i, utm)));
    stl += std::string(2, '\0');
  }
  EXPECT_EQ(import("t.stl", stl, {.largestExtent_m = 0.1})->report.rounding_m,
            0.25 * import("t.stl", stl, {.largestExtent_m = 0.1})->report.scale_m);
}

TEST_F(ImportObj, GoesOnAfterABackslash) {
  const std::string triangle = "v 0 0 0\nv 1 0 \\\n0\nv 0\\ \r\n 1 0\nf 1\\\n 2 \\\n\\\n 3\n";
  EXPECT_EQ(import("t.obj", triangle)->mesh, import("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->mesh);
  EXPECT_THAT(refusal("t.obj", "v 0 0 0 \\\nv 1 0 0\n"), HasSubstr("line 2: vertex 0 (from 0) has \"v\""));
  EXPECT_THAT(refusal("t.obj", "vt 0 0 \\\nv 1 0 0\n"), HasSubstr("line 2: \"v\" where a number should be"));
  EXPECT_THAT(refusal("t.obj", "f 1 2 3 \\\nf 2 3 4\n"), HasSubstr("line 2: \"f\""));
}

TEST_F(ImportObj, SaysWhatItHoldsInPlaceOfFaces) {
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nl 1 2\np 1\nsurf 0 1 0 1 1 2 3\nface 1 2 3\nface 1 2 3\n"),
              HasSubstr("holds 1 vertices and no face (\"f\"), 2 lines and points, which have no surface, 1 free-form "
                        "shapes, which are not read, 2 lines that begin with no keyword of OBJ, the first is line 5: "
                        "\"face\"; a mesh needs at least one face"));
}

TEST_F(ImportObj, TakesAnythingAsAVertexThatNoFaceNames) {
  const std::string unused = "v nan 0 0\nv 1e300 0 0\nv 1e999 0 0\nv 0 -1.#IND 0\n";
  for (const ImportOptions& options : {ImportOptions{}, ImportOptions{.largestExtent_m = 0.1}}) {
    const auto imported = import("t.obj", std::string(kTetrahedronObj) + unused, options);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, import("t.obj", kTetrahedronObj, options)->mesh);
    EXPECT_EQ(imported->report.verticesUnused + imported->report.verticesWelded, 4U);
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

TEST_F(ImportObj, TakesNumbersAsOtherReadersDo) {
  const TriMesh expected = import("t.obj", "v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->mesh;
  for (const std::string vertex : {"0,5 0 0", "0.5, 0, 0", ".5f 0.F 0", "0.5 0 0 white", "0,500 0,0 -0,0 1"}) {
    EXPECT_EQ(import("t.obj", "v " + vertex + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->mesh, expected) << vertex;
  }
  for (const std::string face : {"1, 2, 3", "1.0 2. 3.00/1", "1\\1\\1 2\\1\\1 3\\1\\1"}) {
    EXPECT_EQ(import("t.obj", "v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf " + face + "\n")->mesh, expected) << face;
  }
  EXPECT_EQ(import("t.obj", "v 0 0 0 white\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->report.linesSkipped, 1U);
  EXPECT_THAT(refusal("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3.5\n"), HasSubstr("line 4: \"3.5\""));
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
  EXPECT_THAT(refusal("t.obj", "v 0 0 1,5,6\n"), HasSubstr("\"1,5,6\" where a number should be"));
  EXPECT_THAT(refusal("t.obj", "v 0 0 1,234.5\n"), HasSubstr("\"1,234.5\" where a number should be"));
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

TEST_F(ImportObj, CountsLinesAndPointsBesideFaces) {
  const auto imported = import("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2 3\nl 1 3\np 1\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.leftOut.lines, 2U);
  EXPECT_EQ(imported->report.leftOut.points, 1U);
}

TEST_F(ImportOff, QuotesWordsInUtf8) {
  EXPECT_THAT(refusal("t.off", "Größe\n"), HasSubstr("begins with \"Größe\""));
  EXPECT_THAT(refusal("t.off", "Gr\xf6\xdf\x1b\n"), HasSubstr(R"(begins with "Gr\xf6\xdf\x1b")"));
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

TEST_F(ImportOff, RefusesNumbersThatCanBeReadInTwoWays) {
  // The first 0 is the number of edges, and "3 0 1 2" the face; or it is a coordinate, and "4 3 0 1 2" is.
  EXPECT_THAT(refusal("t.off", "OFF\n4 1\n0 0 0 1 0 0 1 1 0 0 1 0 4 3 0 1 2\n"), HasSubstr("in more than one way"));
  EXPECT_EQ(import("t.off", "OFF\n3 1 0\n0 0 0 1 0 0 0 1 0 3 0 1 2")->report.kept, 1U);
}

/// The words of a grid's faces make other polygons in each layout that is tried.
TEST_F(ImportOff, CutsPolygonsInTheOneLayoutAlone) {
  constexpr int kSide = 100;
  std::string vertices, faces;
  for (int i = 0; i < kSide * kSide; ++i) {
    vertices += std::to_string(i % kSide) + ' ' + std::to_string(i / kSide) + " 0.5\n";
    if (i % kSide == 0 || i < kSide) continue;
    const auto corner = [&](int back) { return ' ' + std::to_string(i - back); };
    faces += '3' + corner(0) + corner(1) + corner(kSide) + "\n3" + corner(1) + corner(kSide + 1) + corner(kSide) + '\n';
  }
  const std::string lines = "OFF\n10000 19602 0\n" + vertices + faces;
  std::string line = lines;
  std::ranges::replace(line, '\n', ' ');
  const auto time_s = [](const std::string& text) {
    const std::clock_t begin = std::clock();
    EXPECT_EQ(import("t.off", text)->report.kept, 19602U);
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  };
  const double each_s = time_s(lines), one_s = time_s(line);
  EXPECT_LT(one_s, 3 * each_s);
}

TEST_F(ImportOff, NamesTheLineOfAFaceThatItsCountTakesForAVertex) {
  EXPECT_THAT(refusal("t.off", "OFF\n5 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n6 3 0 3 2 1 0\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"),
              HasSubstr("line 7: is a face, where the 5 vertices end"));
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

TEST(WriteFile, NamesTheFileThatCannotBeWritten) {
  const Result<void> written = writeFile("no/such/folder/summary.json", "{}");
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().text(), HasSubstr("no/such/folder/summary.json"));
}

TEST(WriteFile, ReplacesWhatWasThere) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "summary.json";
  ASSERT_TRUE(writeFile(file, "long old text"));
  ASSERT_TRUE(writeFile(file, "new"));
  std::string text;
  std::getline(std::ifstream(file), text);
  EXPECT_EQ(text, "new");
}

/// As of a full disk: the device takes nothing.
TEST(WriteFile, LeavesWhatWasThereWhereItCannotBeReplaced) {
  if (!std::ofstream("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "summary.json", partial = folder / "summary.json.part";
  ASSERT_TRUE(writeFile(file, "earlier"));
  std::filesystem::create_symlink("/dev/full", partial);
  const Result<void> written = writeFile(file, "new");
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().text(), HasSubstr("No space left"));
  EXPECT_EQ(readFile(file).value(), "earlier");
  EXPECT_FALSE(std::filesystem::is_symlink(partial));
}

}  // namespace
}  // namespace haptics::import_test
