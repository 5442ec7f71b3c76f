#include <tuple>
#include <utility>
#include <vector>

#include "file_imports.h"

// Files in text, as the FBX SDK writes them; the binary spelling of the same is in import_assimp_test.cpp.
namespace haptics::import_fbx_test {
namespace {

using fixture::tetrahedron;
using ::testing::AllOf;
using ::testing::HasSubstr;

using ImportFbx = fixture::FileImports;

const std::string kTetrahedron = R"(	Geometry: 10, "Geometry::tetra", "Mesh" {
		Vertices: *12 {
			a: 0,0,0,1,0,0,0,1,0,0,0,1
		}
		PolygonVertexIndex: *12 {
			a: 0,2,-2,0,1,-4,1,2,-4,2,0,-4
		}
	}
)";
const std::string kPatch = R"(	Geometry: 11, "Geometry::patch", "NurbsSurface" {
		NurbsSurfaceOrder: 2,2
		Dimensions: 2,2
		Points: *16 {
			a: 0,0,0,1,1,0,0,1,0,1,0,1,1,1,0,1
		}
	}
)";
const std::string kFarAway = "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",5,0,0\n";
const std::string kNotVisible = "P: \"Visibility\", \"Visibility\", \"\", \"A\",0\n";
const std::string kNotShown = "P: \"Show\", \"bool\", \"\", \"\",0\n";

std::string model(int id, const std::string& properties = "", const std::string& kind = "Mesh") {
  return "\tModel: " + std::to_string(id) + ", \"Model::m" + std::to_string(id) + "\", \"" + kind +
         "\" {\n\t\tProperties70:  {\n" + properties + "\t\t}\n\t}\n";
}

/// In metres. @param links  What is below what; 0 is the scene.
std::string fbx(const std::string& objects, const std::vector<std::pair<int, int>>& links, int version = 7400) {
  std::string text = "; FBX project file\nFBXHeaderExtension:  {\n\tFBXVersion: " + std::to_string(version) +
                     "\n}\nGlobalSettings:  {\n\tProperties70:  {\n\t\tP: \"UnitScaleFactor\", \"double\", \"Number\", "
                     "\"\",100\n\t}\n}\nObjects:  {\n" +
                     objects + "}\nConnections:  {\n";
  for (const auto& [below, above] : links)
    text += "\tC: \"OO\"," + std::to_string(below) + "," + std::to_string(above) + "\n";
  return text + "}\n";
}

/// The tetrahedron, and once more 5 m away by objects of which only that one leads to 21.
std::string twice(const std::string& objects, std::vector<std::pair<int, int>> links) {
  for (const auto& link : {std::pair{20, 0}, {10, 20}, {10, 21}}) links.push_back(link);
  return fbx(kTetrahedron + model(20) + objects, links);
}

TEST_F(ImportFbx, ShowsWhatIsNotHidden) {
  const std::string layer = R"(	CollectionExclusive: 40, "DisplayLayer::l", "DisplayLayer" {
		Properties70:  {
)" + kNotShown + "\t\t}\n\t}\n";
  for (const std::string& hidden :
       {twice(model(21, kFarAway + kNotVisible), {{21, 0}}), twice(model(21, kFarAway + kNotShown), {{21, 0}}),
        twice(model(22, kNotVisible, "Null") + model(21, kFarAway), {{22, 0}, {21, 22}}),
        twice(layer + model(21, kFarAway), {{21, 0}, {21, 40}}), twice(model(21, kFarAway), {})}) {
    const auto imported = import("t.fbx", hidden);
    ASSERT_TRUE(imported) << hidden << imported.error().text();
    EXPECT_EQ(imported->mesh, tetrahedron()) << hidden;
  }
  EXPECT_EQ(import("t.fbx", twice(model(21, kNotShown), {{21, 0}}))->report.leftOut.unshown, 1U);

  const std::string own = kFarAway + "P: \"Visibility Inheritance\", \"Visibility Inheritance\", \"\", \"\",0\n";
  for (const std::string& shown : {twice(model(21, kFarAway), {{21, 0}}),
                                   twice(model(22, kNotVisible, "Null") + model(21, own), {{22, 0}, {21, 22}}),
                                   twice(model(22, kNotShown, "Null") + model(21, kFarAway), {{22, 0}, {21, 22}})}) {
    const auto imported = import("t.fbx", shown);
    ASSERT_TRUE(imported) << shown << imported.error().text();
    EXPECT_EQ(imported->mesh.triangles.size(), 8U) << shown;
    EXPECT_EQ(imported->report.leftOut.unshown, 0U) << shown;
  }
  EXPECT_THAT(refusal("t.fbx", fbx(kTetrahedron + model(20, kNotVisible), {{20, 0}, {10, 20}})),
              HasSubstr("holds no mesh that its scene shows; hidden, or without a place in it: 1"));
}

TEST_F(ImportFbx, CountsMeshesWithoutAPlaceAndWhatIsNoMesh) {
  const std::string alone = fbx(kTetrahedron + model(20), {{20, 0}, {10, 20}});
  std::string more = kTetrahedron;
  more.replace(more.find("10,"), 3, "12,");
  EXPECT_EQ(import("t.fbx", fbx(kTetrahedron + more + model(20), {{20, 0}, {10, 20}}))->report.leftOut.unshown, 1U);

  const auto beside = fbx(kTetrahedron + kPatch + model(20) + model(21, kFarAway, "NurbsSurface"),
                          {{20, 0}, {10, 20}, {21, 0}, {11, 21}});
  const auto imported = import("t.fbx", beside);
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh, tetrahedron());
  EXPECT_EQ(imported->report.shapesSkipped, 1U);
  EXPECT_THAT(refusal("t.fbx", fbx(kPatch + model(21, "", "NurbsSurface"), {{21, 0}, {11, 21}})),
              HasSubstr("nothing but 1 parts that are not read: NURBS"));
}

TEST_F(ImportFbx, SaysWhatIsNotAsItShouldBe) {
  const std::string right = fbx(kTetrahedron + model(20), {{20, 0}, {10, 20}});
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = right;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(import("t.fbx", "\xef\xbb\xbf" + right)->mesh, tetrahedron());
  EXPECT_THAT(refusal("t.fbx", changed("7400", "6100")),
              HasSubstr("is FBX of version 6100 (FBXVersion); 7100, of 2011, and later ones are read"));
  EXPECT_THAT(refusal("t.fbx", changed(",2,0,-4", ",2,0,-9")),
              HasSubstr("the geometry \"tetra\" names vertex 8 (from 0) of 4 in PolygonVertexIndex"));
  EXPECT_THAT(refusal("t.fbx", changed(",2,0,-4", ",2,0,3")),
              AllOf(HasSubstr("\"tetra\" whose last polygon does not end"), HasSubstr("PolygonVertexIndex is 3")));
  EXPECT_THAT(refusal("t.fbx", right.substr(0, right.find("C: \"OO\",10"))), HasSubstr("is cut off"));
}

TEST_F(ImportFbx, RefusesScalesThatAreInheritedOtherwise) {
  const auto below = [](const std::string& scale, int type, const std::string& turn) {
    const std::string own = "P: \"InheritType\", \"enum\", \"\", \"\"," + std::to_string(type) + "\n" +
                            "P: \"Lcl Rotation\", \"Lcl Rotation\", \"\", \"A\",0,0," + turn + "\n";
    return fbx(kTetrahedron + model(22, "P: \"Lcl Scaling\", \"Lcl Scaling\", \"\", \"A\"," + scale + "\n", "Null") +
                   model(21, own),
               {{22, 0}, {21, 22}, {10, 21}});
  };
  for (const auto& [scale, type, turn] :
       {std::tuple{"2,1,1", 1, "90"}, {"2,2,2", 0, "90"}, {"2,1,1", 0, "0"}, {"1,1,1", 2, "90"}})
    EXPECT_TRUE(import("t.fbx", below(scale, type, turn))) << scale << type << turn;
  for (const auto& [scale, type, turn] : {std::tuple{"2,1,1", 0, "90"}, {"2,2,2", 2, "0"}}) {
    EXPECT_THAT(refusal("t.fbx", below(scale, type, turn)),
                HasSubstr("has the model \"m21\" of InheritType " + std::to_string(type) + " below \"m22\""));
  }
}

}  // namespace
}  // namespace haptics::import_fbx_test
