#include <libdeflate.h>
#include <sys/stat.h>

#include <memory>
#include <random>
#include <sstream>
#include <thread>

#include "file_imports.h"

namespace haptics::import_inventor_test {
namespace {

using fixture::tetrahedron;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;

using ImportInventor = fixture::FileImports;

const std::string kHeader = "#Inventor V2.1 ascii\n\n";
const std::string kTetrahedron =
    "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] }\n"
    "IndexedFaceSet { coordIndex [ 0,2,1,-1, 0,1,3,-1, 1,2,3,-1, 2,0,3,-1 ] }\n";
const std::string kNurbs =
    "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 1 1 0 ] }\n"
    "NurbsSurface { numUControlPoints 2 numVControlPoints 2 uKnotVector [0,0,1,1] vKnotVector [0,0,1,1] }\n";

std::string gzip(const std::string& text) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> packer(
      libdeflate_alloc_compressor(6), &libdeflate_free_compressor);
  std::string packed(libdeflate_gzip_compress_bound(packer.get(), text.size()), '\0');
  packed.resize(libdeflate_gzip_compress(packer.get(), text.data(), text.size(), packed.data(), packed.size()));
  return packed;
}

double volume_m3(const TriMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : mesh.triangles) {
    sum += glm::dot(Vec3(mesh.vertices[a]), glm::cross(Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c]))) / 6;
  }
  return sum;
}

TEST_F(ImportInventor, SaysWhatFloat32LeavesOfWhatATransformBringsBack) {
  const auto imported = import("t.iv", kHeader +
                                           "Translation { translation -691234.5 -5334567.25 -512 }\n"
                                           "Coordinate3 { point [ 691234.5 5334567.25 512, 691235.5 5334567.25 512, "
                                           "691234.5 5334568.25 512, 691234.5 5334567.25 513 ] }\n" +
                                           kTetrahedron.substr(kTetrahedron.find("Indexed")));
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_GE(imported->report.rounding_m, 0.25);
  EXPECT_THAT(imported->report.text(), HasSubstr("so far from the origin"));
}

TEST_F(ImportInventor, NamesTheInlineOfVrml1AndUtf16) {
  const std::string inner = "#VRML V1.0 ascii\nWWWInline { name \"inner.wrl\" }\n";
  EXPECT_THAT(refusal("t.wrl", inner),
              HasSubstr("holds nothing but what is in files that cannot be read, or are not in its folder or below: "));
  EXPECT_EQ(import("t.wrl", inner + kTetrahedron)->report.shapesSkipped, 1U);
  write("inner.wrl", "#VRML V1.0 ascii\n" + kTetrahedron);
  const auto inlined = import("t.wrl", inner);
  ASSERT_TRUE(inlined) << inlined.error().text();
  EXPECT_EQ(inlined->mesh, tetrahedron());
  EXPECT_EQ(inlined->report.shapesSkipped, 0U);
  write("crank.iv", kHeader + "Crank { radius 1 }");
  for (const std::string file : {"crank.iv", "missing.iv"}) {
    const std::string included = kHeader + "File { name \"" + file + "\" }\n";
    EXPECT_THAT(refusal("t.iv", included),
                HasSubstr("in files that cannot be read, or are not in its folder or below: \"" + file));
    EXPECT_EQ(import("t.iv", included + kTetrahedron)->report.shapesSkipped, 1U) << file;
  }
  EXPECT_THAT(refusal("t.wrl", "#VRML V2.0 utf8\nPROTO P [ ] { Shape { geometry Box { } } }\n"),
              HasSubstr("holds no face; a mesh needs"));
  std::filesystem::create_directory(folder_ / "parts");
  write("parts/part.wrl", "#VRML V2.0 utf8\nShape { geometry Box {} }\nInline { url \"part.wrl\" }\n");
  write("parts/all.wrl",
        "#VRML V2.0 utf8\nInline { url [ \"http://here.org/a.wrl\", \"missing.wrl\", \"part.wrl#top\" ] }\n");
  const auto below =
      import("t.wrl", "#VRML V2.0 utf8\nTransform { translation 3 0 0 children Inline { url \"parts/all.wrl\" } }\n");
  ASSERT_TRUE(below) << below.error().text();
  EXPECT_EQ(below->report.boxMin_m, Vec3(2, -1, -1));
  EXPECT_EQ(below->report.boxMax_m, Vec3(4, 1, 1));
  EXPECT_EQ(below->report.shapesSkipped, 1U);  // the ring's end
  std::string many = "#VRML V2.0 utf8\n";
  for (int i = 0; i < 200; ++i)
    many += "Transform { translation 0 " + std::to_string(3 * i) + " 0 children Inline { url \"box.wrl\" } }\n";
  write("box.wrl", "#VRML V2.0 utf8\nShape { geometry Box {} }\n");
  EXPECT_EQ(import("t.wrl", many)->report.closedParts, 200U);
  std::string wide;
  for (const char c : kHeader + kTetrahedron) wide += {c, '\0'};
  EXPECT_THAT(refusal("t.iv", wide), HasSubstr("UTF-16"));
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

TEST_F(ImportInventor, ClosesTheSeamsOfRoundShapes) {
  for (const char* shape : {"Sphere { radius 1 }", "Cone { height 9 }", "Cylinder { }"}) {
    for (const char* complexity : {"0.1", "0.5", "0.73", "1"}) {
      for (const char* scale : {"", "Scale { scaleFactor 1 0.001 7 }"}) {
        const auto imported = import("t.iv", kHeader + scale + "Complexity { value " + complexity + " } " + shape);
        ASSERT_TRUE(imported) << imported.error().text();
        EXPECT_TRUE(imported->report.closed()) << shape << complexity << imported->report.text();
      }
    }
  }
}

TEST_F(ImportInventor, TakesABillboardAsItStands) {
  const auto imported =
      import("t.wrl",
             "#VRML V2.0 utf8\nTransform { rotation 0 0 1 1.5707963 translation 5 0 0 children Billboard { "
             "children Transform { translation 1 0 0 children Shape { geometry Box {} } } } }\n");
  ASSERT_TRUE(imported) << imported.error().text();
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(imported->report.boxMax_m[axis], Vec3(6, 2, 1)[axis], 1e-5) << axis;
}

TEST_F(ImportInventor, TakesTheFinestLevelHoweverFarAway) {
  const std::string far = "Translation { translation 50 0 0 }\n",
                    levels = "{ Separator { Cube {} } Separator { Cube { width 9 } } }\n";
  for (const std::string& file :
       {kHeader + far + "LOD { range [ 5 ] " + levels.substr(1),
        kHeader + far + "LevelOfDetail { screenArea [ 5 ] " + levels.substr(1),
        std::string(
            "#VRML V2.0 utf8\nTransform { translation 50 0 0 children LOD { range 5 level [ Shape { geometry Box {} } "
            "Shape { geometry Box { size 9 2 2 } } ] } }\n")}) {
    const auto imported = import("t.wrl", file);
    ASSERT_TRUE(imported) << file << imported.error().text();
    EXPECT_EQ(imported->report.boxMin_m, Vec3(49, -1, -1)) << file;
    EXPECT_EQ(imported->report.boxMax_m, Vec3(51, 1, 1)) << file;
    EXPECT_EQ(imported->report.leftOut.unshown, 1U) << file;
  }
  const auto after =
      import("t.iv", kHeader + "LOD { range [ 5 ] Translation { translation 3 0 0 } Separator {} }\nCube {}\n");
  EXPECT_EQ(after->report.boxMax_m, Vec3(4, 1, 1));
}

TEST_F(ImportInventor, CountsWhatIsNotShown) {
  const auto imported =
      import("t.iv", kHeader + "Separator { DrawStyle { style INVISIBLE } Cube { width 9 } }\n" + kTetrahedron +
                         "Switch { Sphere { } Cone { } }\nSwitch { whichChild 1 Cube { } DEF a Group { } USE a }");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_EQ(imported->report.leftOut.unshown, 4U);
}

TEST_F(ImportInventor, TurnsElevationsOfOtherWinding) {
  const auto imported = import("t.wrl",
                               "#VRML V2.0 utf8\nShape { geometry ElevationGrid { xDimension 2 zDimension 2 "
                               "height [ 0 0 0 0 ] ccw FALSE } }");
  ASSERT_TRUE(imported) << imported.error().text();
  const auto [a, b, c] = imported->mesh.triangles[0];
  const auto at = [&](std::uint32_t v) { return Vec3(imported->mesh.vertices[v]); };
  EXPECT_LT(glm::cross(at(b) - at(a), at(c) - at(a)).y, 0);
}

TEST_F(ImportInventor, SaysWhatCoinCannotReadAndWhere) {
  EXPECT_THAT(
      refusal("t.iv",
              kHeader + "Separator { Texture2 { filename \"none.rgb\" }\n Cube { width 3 }\n Cube { widht 3 } }"),
      ::testing::AllOf(HasSubstr("widht"), HasSubstr("line 5"), ::testing::Not(HasSubstr("none.rgb"))));
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
  EXPECT_THAT(refusal("t.iv", "just text\n"), HasSubstr("begins with \"just text\"; the first line"));
  EXPECT_THAT(refusal("t.iv", kHeader + "Separator { Cube {"),
              AllOf(HasSubstr("2 braces or brackets are open"), HasSubstr("Coin says")));
  EXPECT_THAT(refusal("t.wrl", "#VRML V3.0 utf8\nShape { }\n"), HasSubstr("is VRML of another version"));
  EXPECT_TRUE(import("t.wrl", "#VRML V2.0 UTF8\nShape { geometry Box { } }\n"));
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

TEST_F(ImportInventor, NamesPointsAndHeightsThatAreNotThereOfEveryKindOfShape) {
  const std::string points = kHeader + "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0 ] }\n";
  const std::string vrml = "#VRML V2.0 utf8\nShape { geometry ";
  const std::string file[][2] = {
      {points + "FaceSet { numVertices [ 3, 1000000 ] }", "asks for 1000000 points from point 3 of 3"},
      {points + "FaceSet { startIndex 1 numVertices 3 }", "asks for 3 points from point 1 of 3"},
      {points + "FaceSet { numVertices -2 }", "asks for -2 points from point 0 of 3"},
      {points + "FaceSet { startIndex -1 }", "from point -1 of 3"},
      {points + "TriangleStripSet { numVertices [ 500000 ] }", "asks for 500000 points from point 0 of 3"},
      {points + "IndexedTriangleStripSet { coordIndex [ 0, 1, 2, 3, -1 ] }", "names point 3 of 3"},
      {points + "QuadMesh { verticesPerRow 2 verticesPerColumn 2 }", "asks for 2 rows of 2 points from point 0 of 3"},
      {points + "QuadMesh { verticesPerRow 2147483647 verticesPerColumn 2147483647 }", "of 3"},
      {kHeader + "IndexedFaceSet { vertexProperty VertexProperty { vertex [ 0 0 0, 1 0 0 ] } coordIndex [ 0, 1, 2 ] }",
       "names point 2 of 2"},
      {vrml + "IndexedFaceSet { coordIndex [ 0, 1, 2 ] } }", "names point 0 of 0"},
      {vrml + "IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0 ] } coordIndex [ 0, 1, 2 ] } }",
       "names point 2 of 2"},
      {vrml + "ElevationGrid { xDimension 70000 zDimension 70000 height [ 0, 0, 0, 0 ] } }", "70000 heights of 4"}};
  for (const auto& [text, reason] : file) EXPECT_THAT(refusal("t.iv", text), HasSubstr(reason)) << text;
}

TEST_F(ImportInventor, LeavesAShortFaceOutAloneAndCountsIt) {
  for (const char* face : {"-1,", "0,-1,", "0,1,-1,", "0,-2,1,-1,"}) {
    for (const std::size_t place : {2U, 11U}) {
      std::string indices = "[ 0,2,1,-1, 0,1,3,-1, 1,2,3,-1, 2,0,3 ]";
      indices.insert(place, face);
      for (const std::string& shape :
           {kHeader + "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] }\nIndexedFaceSet { coordIndex " + indices +
                '}',
            "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 "
            "] "
            "} coordIndex " +
                indices + "} }"}) {
        const auto imported = import("t.iv", shape);
        ASSERT_TRUE(imported) << imported.error().text() << shape;
        EXPECT_EQ(imported->mesh, tetrahedron()) << shape;
        EXPECT_GE(imported->report.droppedDegenerate, 1U) << shape;
      }
    }
  }
}

TEST_F(ImportInventor, TakesEveryKindOfShapeTheSameWayRound) {
  const std::string corners =
      "point [ 0 0 0, 0 1 0, 1 0 0, 0 0 0, 1 0 0, 0 0 1, 1 0 0, 0 1 0, 0 0 1, 0 1 0, 0 0 0, 0 0 1 ] }\n";
  const std::string strip = "point [ 0 0 1, 0 1 0, 0 0 0, 1 0 0, 0 0 1, 0 1 0 ] }\n";
  for (const std::string& shape : {"Coordinate3 { " + corners + "FaceSet { numVertices [ 3, 3, 3, -1 ] }",
                                   "Coordinate3 { " + strip + "TriangleStripSet { numVertices -1 }",
                                   std::string("Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] "
                                               "}\nIndexedTriangleStripSet { coordIndex [ 3, 2, 0, 1, 3, 2, -1 ] }")}) {
    const auto imported = import("t.iv", kHeader + shape);
    ASSERT_TRUE(imported) << imported.error().text() << shape;
    EXPECT_TRUE(imported->report.closed()) << shape;
    EXPECT_NEAR(volume_m3(imported->mesh), 1.0 / 6, 1e-6) << shape;
  }
  // Coin faces these towards z.
  const auto quads = import("t.iv", kHeader +
                                        "Coordinate3 { point [ 0 1 0, 1 1 0, 2 1 0, 0 0 0, 1 0 0, 2 0 0 ] }\n"
                                        "QuadMesh { verticesPerRow 3 verticesPerColumn 2 }");
  ASSERT_TRUE(quads) << quads.error().text();
  EXPECT_EQ(quads->report.kept, 4U);
  for (const auto [a, b, c] : quads->mesh.triangles) {
    const Vec3 at(quads->mesh.vertices[a]);
    EXPECT_GT(glm::cross(Vec3(quads->mesh.vertices[b]) - at, Vec3(quads->mesh.vertices[c]) - at).z, 0);
  }
  const auto turned =
      import("t.iv",
             "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { ccw FALSE coord Coordinate { point [ 0 "
             "0 0, 1 0 0, 0 1 0, 0 0 1 ] } coordIndex [ 1,2,0,-1, 3,1,0,-1, 3,2,1,-1, 3,0,2,-1 ] } }");
  ASSERT_TRUE(turned) << turned.error().text();
  EXPECT_NEAR(volume_m3(turned->mesh), 1.0 / 6, 1e-6);
}

TEST_F(ImportInventor, HeedsNoIndicesOfWhatCannotBeFelt) {
  std::string file =
      kHeader + "Normal { vector [ 0 0 1 ] } NormalBinding { value PER_VERTEX_INDEXED }\n" + kTetrahedron;
  file.insert(file.rfind('}'),
              "normalIndex [ 900000, 900000, 900000, -1 ] materialIndex [ 9 ] textureCoordIndex [ 7 ]");
  const auto imported = import("t.iv", file);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
}

TEST_F(ImportInventor, ReadsPackedFilesAndThoseWithAByteOrderMarkOrBlanksFirst) {
  const std::string text = kHeader + kTetrahedron;
  for (const char* before : {"\xef\xbb\xbf", "\n", " \r\n\t", "\xef\xbb\xbf\n"}) {
    const auto imported = import("t.iv", before + text);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron());
  }
  const std::string packed = gzip(text);
  const auto imported = import("t.iv", packed);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_EQ(import("t.WRZ", packed)->mesh, tetrahedron());
  EXPECT_EQ(import("t.iv", gzip(text.substr(0, 40)) + gzip(text.substr(40)))->mesh, tetrahedron()) << "of two parts";
  write("part.iv", packed);
  EXPECT_EQ(import("t.iv", kHeader + "File { name \"part.iv\" }\n")->mesh, tetrahedron());
  for (std::size_t cut = 2; cut < packed.size(); ++cut) {
    EXPECT_THAT(refusal("t.iv", packed.substr(0, cut)), HasSubstr("gzip"));
  }
  EXPECT_THAT(refusal("t.iv", packed.substr(0, packed.size() - 4) + "\xff\xff\xff\xff"), ::testing::Ne("loaded"));
}

TEST_F(ImportInventor, CountsWhatIsNoSurface) {
  for (const char* other :
       {"LineSet {}", "PointSet {}", "Text2 { string \"a\" }", "Unheard { fields [ SFFloat x ] x 1 }"}) {
    const auto imported = import("t.iv", kHeader + "Separator {" + other + "}\n" + kTetrahedron);
    ASSERT_TRUE(imported) << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron());
    EXPECT_EQ(imported->report.shapesSkipped, 1U) << other;
  }
}

TEST_F(ImportInventor, RefusesFewBytesThatMakeMuch) {
  std::string bomb = kHeader + "DEF A0 Separator { Cube {} }\n", chain = bomb;
  for (int i = 1; i < 12; ++i) {
    bomb += "DEF A" + std::to_string(i) + " Separator {";
    for (int k = 0; k < 10; ++k) bomb += " USE A" + std::to_string(i - 1);
    bomb += " }\n";
  }
  chain.insert(chain.find("DEF"), "Switch {");
  for (int i = 1; i < 5000; ++i) {
    chain += "DEF A" + std::to_string(i) + " Separator { USE A" + std::to_string(i - 1) + " }\n";
  }
  const std::string array = "Array { numElements1 30000 numElements2 30000 numElements3 30000 ";
  EXPECT_THAT(refusal("t.iv", kHeader + array + "Cube {} }"), HasSubstr("by repeating"));
  EXPECT_THAT(refusal("t.iv", kHeader + array + "Separator {} }"), HasSubstr("by repeating"));
  EXPECT_THAT(refusal("t.iv", kHeader + "Array { numElements1 1000 numElements2 1000 Cube {} }"),
              HasSubstr("triangles by repeating"));
  EXPECT_THAT(refusal("t.iv", bomb), HasSubstr("by repeating"));
  EXPECT_THAT(refusal("t.iv", chain + "}\n"), HasSubstr("levels deep"));
  EXPECT_THAT(refusal("t.iv", kHeader + "DEF A Separator { Cube {} USE A }"), HasSubstr("within itself"));
  std::string section, spine;
  for (int i = 0; i < 4000; ++i) {
    section += std::to_string(i % 7) + ' ' + std::to_string(i % 11) + ' ';
    spine += std::to_string(i) + ' ' + std::to_string(i % 5) + " 0 ";
  }
  EXPECT_THAT(refusal("t.wrl", "#VRML V2.0 utf8\nShape { geometry Extrusion { crossSection [" + section + "] spine [" +
                                   spine + "] } }"),
              AnyOf(HasSubstr("memory than a file of its size"), HasSubstr("too long"), HasSubstr("by round ones")));
  EXPECT_EQ(import("t.iv", kHeader + "Array { numElements1 30 Cube {} }")->report.trianglesInFile, 360U);
}

TEST_F(ImportInventor, RefusesNestingThatWouldOverflowTheStack) {
  std::string returns = "#Inventor V2.1 ascii\r";
  for (int i = 0; i < 100'000; ++i) returns += "Separator {";
  EXPECT_THAT(refusal("t.iv", returns), HasSubstr("nests more than 500 levels deep"));
  std::string deep = kHeader;
  for (int i = 0; i < 200'000; ++i) deep += "Separator{";
  EXPECT_THAT(refusal("t.iv", deep), HasSubstr("levels deep"));
  EXPECT_TRUE(import("t.iv", kHeader + "# {{{{\nSeparator { Label { label \"" + std::string(1000, '{') + "\" } " +
                                 kTetrahedron + "}"));
}

const std::string kVrml = "#VRML V2.0 utf8\n";

std::string boxAt(const std::string& x) {
  return "Transform { translation " + x + " 0 0 children [ Shape { geometry Box { size 1 1 1 } } ] }\n";
}

TEST_F(ImportInventor, LeavesOutPrototypesOfFilesThatAreNotThere) {
  const std::string proto = "EXTERNPROTO Far [ field SFVec3f at eventIn SFBool on exposedField MFNode in ]\n";
  const std::string use = "Far { at 1 2 3 in [ Shape { geometry Box { } } ] }\n";
  const auto missing = import("t.wrl", kVrml + proto + "[ \"urn:x\" \"none.wrl#Far\" ]\n" + use + boxAt("0"));
  ASSERT_TRUE(missing) << missing.error().text();
  EXPECT_EQ(missing->report.boxMax_m, Vec3(0.5));
  EXPECT_EQ(missing->report.shapesSkipped, 1U);
  write("far.wrl", kVrml +
                       "PROTO Far [ field SFVec3f at 0 0 0 ] { Transform { translation IS at children [ Shape { "
                       "geometry Box { size 1 1 1 } } ] } }\n");
  const std::string there =
      "EXTERNPROTO Far [ field SFVec3f at ] # or [ \"x.wrl\" ]\n[ \"urn:x\", \"none.wrl\" \"far.wrl#Far\" ]\n";
  const auto found = import("t.wrl", kVrml + there + "Far { at 4 0 0 }\n" + boxAt("0"));
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->report.boxMax_m, Vec3(4.5, 0.5, 0.5));
  EXPECT_EQ(found->report.shapesSkipped, 0U);
}

TEST_F(ImportInventor, RefusesNumbersThatFloat32DoesNotHold) {
  for (const std::string number : {"1e39", "-3.5E+38", "1e999"}) {
    EXPECT_THAT(refusal("t.wrl", kVrml + boxAt("0") + boxAt(number)),
                HasSubstr("has the number \"" + number + "\" at line 3, which float32 does not hold"));
  }
  EXPECT_TRUE(import("t.wrl", kVrml + "# 1e39\n" + boxAt("1e-50") + "DEF a1e39 " + boxAt("3e38")));
}

TEST_F(ImportInventor, SaysWhereAFileIsCutOffUnlessTheMeshIsClosed) {
  const std::string sheet =
      "IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] } coordIndex [ 0 1 2 ] }";
  EXPECT_THAT(refusal("t.wrl", kVrml + "Group { children [ Shape { geometry " + sheet + " }\n"),
              HasSubstr("2 braces or brackets are open"));
}

TEST_F(ImportInventor, FindsFilesByWaysWithBackslashes) {
  std::filesystem::create_directory(folder_ / "parts");
  write("parts/box.wrl", kVrml + boxAt("4"));
  const auto imported = import("t.wrl", kVrml + "Inline { url \"parts\\\\box.wrl\" }\n");
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->report.boxMax_m, Vec3(4.5, 0.5, 0.5));
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
