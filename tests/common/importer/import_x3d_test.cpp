#include <random>
#include <utility>
#include <vector>

#include "file_imports.h"

// Files in the classic encoding (ISO/IEC 19776-2); those in XML are in import_assimp_test.cpp, trees of both in
// scene_trees_test.cpp.
namespace haptics::import_x3d_test {
namespace {

using fixture::tetrahedron;
using ::testing::HasSubstr;

using ImportX3d = fixture::FileImports;

const std::string kShape = R"(Shape { # the solid, "{ [
  appearance DEF Red Appearance { material Material { diffuseColor 1 0 0 } }
  geometry IndexedFaceSet { solid FALSE coordIndex [ 0,2,1,-1 0 1 3 -1 1 2 3 -1 2 0 3 -1 ]
    coord DEF Points Coordinate { point [ 0 0 0,1 0 0 0 1 0 0 0 1 ] } }
}
)";
const std::string kFar = "Transform { translation 5 0 0 children [ " + kShape + " ] }\n";

std::string classic(const std::string& statements) { return "#X3D V3.3 utf8\n" + statements; }

TEST_F(ImportX3d, TakesWhatStandsAmongNodesForWhatItIs) {
  const std::vector<std::pair<std::string, std::uint64_t>> files{
      {"PROFILE Interchange COMPONENT NURBS:2\nMETA \"title\" \"a } and a \\\" [\"\nUNIT angle degree 0.017", 0},
      {"DEF T TimeSensor { loop TRUE } DEF I PositionInterpolator { key [ 0 1 ] keyValue [ 0 0 0, 1 1 1 ] }\n"
       "ROUTE T.fraction_changed TO I.set_fraction",
       0},
      {"DEF S Script { inputOnly SFTime time initializeOnly SFNode far " + kFar +
           " inputOutput MFInt32 none [] field SFVec3f at 0 -1 .5 eventOut SFBool done\n"
           " url \"javascript: function f() { return '}'; }\" directOutput TRUE }",
       0},
      {"PROTO P [ inputOutput SFVec3f at 0 0 0 ] { Transform { translation IS at children " + kFar +
           " } }\nP { at 1 0 0 }",
       1},
      {"EXTERNPROTO Q [ inputOutput SFFloat size ] [ \"q.x3dv#Q\" ]\nDEF A Q { size 3 }", 1},
      {"IMPORT inner.Thing AS Other EXPORT T AS Tee", 0},
      {"Switch { whichChoice 1 children [ " + kFar + " Group { } NULL ] }", 0},
      {"Toggler { states [ " + kFar + " ] } Shape { geometry Teapot { size 1 } }", 2},
      {"Inline { url [ \"missing.x3dv\", \"http://here.org/t.x3dv\" ] }", 1}};
  for (const auto& [statements, skipped] : files) {
    const auto imported = import("t.x3dv", classic(statements + "\n" + kShape));
    ASSERT_TRUE(imported) << statements << ": " << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron()) << statements;
    EXPECT_EQ(imported->report.shapesSkipped, skipped) << statements;
  }
}

TEST_F(ImportX3d, InlinesFilesInEachEncoding) {
  write("tetra.x3dv", classic("UNIT length decimetre 0.1\n" + kShape));
  write("tetra.wrl", "\xef\xbb\xbf#VRML V2.0 utf8\nWorldInfo { title \"a < b & \\\"c\\\"\" }\n" + kShape);
  for (const std::string file : {"tetra.x3dv", "tetra.wrl"}) {
    const auto xml = import("t.x3d", "<X3D><Scene><Inline url='\"" + file + "\"'/></Scene></X3D>");
    ASSERT_TRUE(xml) << file << xml.error().text();
    EXPECT_NEAR(xml->report.longestSide_m(), file == "tetra.wrl" ? 1 : 0.1, 1e-7);
    const auto inlined = import("t.x3dv", classic("DEF I Inline { url \"" + file + "\" } USE I"));
    ASSERT_TRUE(inlined) << file << inlined.error().text();
    EXPECT_EQ(inlined->report.trianglesInFile, 8U);
  }
}

TEST_F(ImportX3d, SaysWhereTheClassicEncodingIsBroken) {
  for (const auto& [statements, reason] : std::vector<std::pair<std::string, const char*>>{
           {"Group {\n children [\n", "line 4: ends where a node should be"},
           {"Group {\n } }", "line 3: has \"}\" where a node should be"},
           {"Group\n[ ]", "line 3: has \"[\" where \"{\" should be"},
           {"Group { 3 }", "line 2: has \"3\" where a field or \"}\" should be"},
           {"Transform { translation [ 1 2 Group { } ] }", "line 2: has \"Group\" where a value or \"]\" should be"},
           {"\nUSE Nobody", "line 3: has \"Nobody\" where the name of a node that stands before it (DEF) should be"},
           {"PROTO P [ ] Group", "line 2: has \"Group\" where \"{\" should be"},
           {"DEF D Group { children [ " + kShape + " USE D ] }",
            "uses a Group of the name \"D\" (USE), which is what it is in"},
           {"Shape { geometry Box { size 1 2 } }", "has a Box whose size has 2 numbers"}}) {
    EXPECT_THAT(refusal("t.x3dv", classic(statements)), HasSubstr(reason)) << statements;
  }
  std::string deep;
  for (int i = 0; i < 2000; ++i) deep += "Group { children ";
  EXPECT_THAT(refusal("t.x3dv", classic(deep)), HasSubstr("nests more than 1000 levels deep"));
}

TEST_F(ImportX3d, EndsOnAnyBytes) {
  std::mt19937 random(3);
  const std::string whole =
      classic("PROTO P [ field SFString s \"x\" ] { Group { } }\nDEF D Group { children [ P { } " + kFar +
              " USE D ] }\n" + kShape);
  for (int round = 0; round < 60; ++round) {
    std::string text = whole.substr(0, round % 3 == 0 ? random() % whole.size() : whole.size());
    for (int k = 0; k < 3; ++k) {
      if (!text.empty()) text[random() % text.size()] = "[]{}\"#\\ \n0a"[random() % 11];
    }
    const auto imported = import("t.x3dv", text);
    EXPECT_TRUE(imported || imported.error().reason.find("ends on it") == std::string::npos) << text;
  }
}

}  // namespace
}  // namespace haptics::import_x3d_test
