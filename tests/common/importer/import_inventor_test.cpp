#include <sys/stat.h>

#include <random>
#include <sstream>
#include <thread>

#include "file_imports.h"

namespace haptics::import_inventor_test {
namespace {

using fixture::tetrahedron;
using ::testing::HasSubstr;

using ImportInventor = fixture::FileImports;

const std::string kHeader = "#Inventor V2.1 ascii\n\n";
const std::string kTetrahedron =
    "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] }\n"
    "IndexedFaceSet { coordIndex [ 0,2,1,-1, 0,1,3,-1, 1,2,3,-1, 2,0,3,-1 ] }\n";
const std::string kNurbs =
    "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 1 1 0 ] }\n"
    "NurbsSurface { numUControlPoints 2 numVControlPoints 2 uKnotVector [0,0,1,1] vKnotVector [0,0,1,1] }\n";

double volume_m3(const TriMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : mesh.triangles) {
    sum += glm::dot(Vec3(mesh.vertices[a]), glm::cross(Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c]))) / 6;
  }
  return sum;
}

TEST_F(ImportInventor, ReadsFaceSetsToTheSameMeshAsOtherFormats) {
  const auto imported = import("t.iv", kHeader + kTetrahedron);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_TRUE(imported->report.closed());
}

TEST_F(ImportInventor, TriangulatesShapesAndAppliesTransforms) {
  const auto imported = import(
      "t.iv", kHeader + "Separator { Translation { translation 10 0 0 } Scale { scaleFactor 2 1 1 } Cube {} }\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.boxMin_m, Vec3(8, -1, -1));
  EXPECT_EQ(imported->report.boxMax_m, Vec3(12, 1, 1));
  EXPECT_TRUE(imported->report.closed());
  EXPECT_NEAR(volume_m3(imported->mesh), 16, 1e-5);
}

TEST_F(ImportInventor, TurnsMirroredAndClockwiseFacesOutward) {
  const double sixth = 1.0 / 6;
  EXPECT_NEAR(volume_m3(import("t.iv", kHeader + "Scale { scaleFactor -1 1 1 }" + kTetrahedron)->mesh), sixth, 1e-6);
  const std::string clockwise =
      "ShapeHints { vertexOrdering CLOCKWISE }\nCoordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] }\n"
      "IndexedFaceSet { coordIndex [ 0,1,2,-1, 0,3,1,-1, 1,3,2,-1, 2,3,0,-1 ] }\n";
  EXPECT_NEAR(volume_m3(import("t.iv", kHeader + clockwise)->mesh), sixth, 1e-6);
  EXPECT_NEAR(volume_m3(import("t.iv", kHeader + "Scale { scaleFactor 1 -1 1 }" + clockwise)->mesh), sixth, 1e-6);
}

TEST_F(ImportInventor, SkipsAndCountsNurbs) {
  const auto imported = import("t.iv", kHeader + "Separator {" + kTetrahedron + "}\nSeparator {" + kNurbs + "}\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_EQ(imported->report.shapesSkipped, 1U);
  EXPECT_THAT(imported->report.text(), HasSubstr("1 parts skipped"));
  EXPECT_THAT(refusal("t.iv", kHeader + kNurbs), HasSubstr("NURBS"));
}

TEST_F(ImportInventor, IncludesFilesFromItsFolderOnly) {
  write("part.iv", kHeader + kTetrahedron);
  EXPECT_EQ(import("t.iv", kHeader + "File { name \"part.iv\" }\n")->mesh, tetrahedron());

  std::filesystem::create_directory(folder_ / "inner");
  const std::string own = "Separator {" + kTetrahedron + "}\n";
  for (const std::string& name : {std::string("../part.iv"), (folder_ / "part.iv").string(), std::string("missing.iv"),
                                  std::string("/dev/zero")}) {
    std::ostringstream file;
    file << kHeader << own << "File { name \"" << name << "\" }\n";
    const auto imported = import("inner/t.iv", file.str());
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron()) << name;
    EXPECT_EQ(imported->report.shapesSkipped, 1U) << name;
  }
}

TEST_F(ImportInventor, FollowsALinkInAnIncludedNameWithinTheAssetFolderOnly) {
  std::filesystem::create_directories(folder_ / "assets/inner");
  std::filesystem::create_directories(folder_ / "secret");
  write("assets/part.iv", kHeader + kTetrahedron);
  write("secret/part.iv", kHeader + kTetrahedron);
  const auto inner = folder_ / "assets/inner";
  std::filesystem::create_symlink(folder_ / "assets/part.iv", inner / "inside.iv");
  std::filesystem::create_symlink(folder_ / "secret/part.iv", inner / "outside.iv");
  std::filesystem::create_directory_symlink(folder_ / "secret", inner / "up");
  const auto including = [&](const std::string& name) {
    return importFile(write("assets/inner/t.iv", kHeader + "Separator { Cube {} }\nFile { name \"" + name + "\" }\n"),
                      folder_ / "assets");
  };
  EXPECT_EQ(including("inside.iv")->report.trianglesInFile, 16U);
  for (const char* name : {"outside.iv", "up/part.iv"}) {
    const auto imported = including(name);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->report.trianglesInFile, 12U) << name;
    EXPECT_EQ(imported->report.shapesSkipped, 1U) << name;
  }
}

TEST_F(ImportInventor, IncludesAFileThatIncludesAnother) {
  write("part.iv", kHeader + kTetrahedron);
  write("middle.iv", kHeader + "File { name \"part.iv\" }\nCube {}\n");
  EXPECT_EQ(import("t.iv", kHeader + "File { name \"middle.iv\" }\n")->report.trianglesInFile, 16U);
}

TEST_F(ImportInventor, EndsWhenAFileIncludesItself) {
  const auto imported = import("t.iv", kHeader + "Separator {" + kTetrahedron + "}\nFile { name \"t.iv\" }\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.shapesSkipped, 1U);
}

TEST_F(ImportInventor, RefusesWhatItCannotRead) {
  EXPECT_THAT(refusal("t.iv", "just text\n"), HasSubstr("cannot be read as Open Inventor"));
  EXPECT_THAT(refusal("t.iv", kHeader + "Separator { Cube {"), HasSubstr("Coin says"));
  EXPECT_THAT(refusal("t.iv", kHeader + "Separator { }"), HasSubstr("no face"));
  EXPECT_THAT(refusal("t.iv", kHeader), ::testing::Ne("loaded"));
  EXPECT_THAT(refusal("t.iv", kHeader + "Coordinate3 { point [ 0 0 0, 1e39 0 0, 0 1 0 ] }\n"
                                        "IndexedFaceSet { coordIndex [ 0, 1, 2, -1 ] }"),
              ::testing::Ne("loaded"));
}

TEST_F(ImportInventor, NamesAPointThatIsNotThere) {
  std::string bad = kHeader + kTetrahedron;
  bad.replace(bad.find("2,0,3"), 5, "2,0,4");
  EXPECT_THAT(refusal("t.iv", bad), HasSubstr("names point 4 of 4"));
}

TEST_F(ImportInventor, OutlivesACrashOfCoin) {
  const std::string bad = "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0 ] }\nFaceSet { numVertices [ 1000000 ] }\n";
  EXPECT_THAT(refusal("t.iv", kHeader + bad), HasSubstr("inventor_importer ends on it"));
}

TEST_F(ImportInventor, RefusesNestingThatWouldOverflowTheStack) {
  std::string deep = kHeader;
  for (int i = 0; i < 200'000; ++i) deep += "Separator{";
  EXPECT_THAT(refusal("t.iv", deep), HasSubstr("levels deep"));
  EXPECT_TRUE(import("t.iv", kHeader + "# {{{{\nSeparator { Label { label \"" + std::string(1000, '{') + "\" } " +
                                 kTetrahedron + "}"));
}

TEST_F(ImportInventor, CanBeUsedFromSeveralThreads) {
  const auto file = write("t.iv", kHeader + kTetrahedron);
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::array<bool, 4> good{};
  for (bool& result : good) {
    threads.emplace_back([&] {
      const auto imported = importFile(file, file.parent_path());
      result = imported && imported->mesh == tetrahedron();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(good, ::testing::Each(true));
}

TEST_F(ImportInventor, ThatIsDamagedIsRefusedOrReportedButNeverFails) {
  const std::string good = kHeader + "Separator { Transform { rotation 0 0 1 1 } Cube {} Sphere {} }\n" + kTetrahedron;
  std::mt19937 random(19);
  for (int round = 0; round < 60; ++round) {
    std::string bad = good.substr(0, round % 3 == 0 ? random() % good.size() : good.size());
    for (int k = 0; k < 2 && !bad.empty(); ++k) bad[random() % bad.size()] = static_cast<char>(random());
    const auto imported = import("t.iv", bad);
    if (imported) {
      EXPECT_TRUE(checkMesh(imported->mesh));
    }
  }
}

}  // namespace
}  // namespace haptics::import_inventor_test
