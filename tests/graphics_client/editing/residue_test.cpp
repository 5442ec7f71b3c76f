#include <gtest/gtest.h>

#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::residue_test {
namespace {

using namespace test;

MovedVertices moved(float by_m) { return {{0}, {Vec3f(by_m)}}; }

v1::Transaction remesh(double side_m) {
  const std::string side = std::to_string(side_m);
  return parsed("operations { remesh { object { name: 'cup' } mesh { box { size_m { x: " + side + " y: " + side +
                " z: " + side + " } } } } }");
}

/// The server leaves residues in the object, which are nobody's edits.
class Residues : public ::testing::Test {
 protected:
  Residues() {
    EXPECT_TRUE(editor.submit(addBox("cup")));
    EXPECT_TRUE(
        editor.submit(parsed("operations { set_deformation { object { name: 'cup' } deformation { softness { "
                             "stiffness_N_per_m: 300 radius_m: 0.02 plastic: 1 } } } }")));
  }
  [[nodiscard]] std::optional<ContentHash> residue() const { return server.scene().find("cup")->deformation.residue; }

  EditServer server;
  Editor editor{server, 1};
};

TEST_F(Residues, OfTheServerDoNotKeepAnEditFromBeingUndone) {
  ASSERT_TRUE(editor.submit(setStiffness("cup", 500)));
  server.bake("cup", moved(0.01F));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(server.scene().find("cup")->material.stiffness_N_per_m, 800);
  EXPECT_EQ(residue(), hashOf(moved(0.01F))) << "it is not the edit's to take away";
  ASSERT_TRUE(editor.redo());
  EXPECT_EQ(residue(), hashOf(moved(0.01F)));
}

TEST_F(Residues, BakedWhileAnEditIsUnderWayStayWhenItIsUndone) {
  editor.history.submit({setStiffness("cup", 500), "Stiffness"});
  server.bake("cup", moved(0.01F));
  editor.client.deliverAll();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(residue(), hashOf(moved(0.01F)));
}

TEST_F(Residues, ComeBackWithTheMeshThatTheyWereLeftOn) {
  server.bake("cup", moved(0.01F));
  const ContentHash content = contentHash(server.scene());
  ASSERT_TRUE(editor.submit(remesh(0.2)));
  EXPECT_FALSE(residue());
  server.bake("cup", moved(0.02F));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(contentHash(server.scene()), content);
  EXPECT_EQ(server.uploads, 2U) << "the mesh and the residue";
  ASSERT_TRUE(editor.redo());
  EXPECT_FALSE(residue());
}

TEST_F(Residues, ComeBackWithTheObject) {
  server.bake("cup", moved(0.01F));
  const ContentHash content = contentHash(server.scene());
  ASSERT_TRUE(editor.submit(removal("cup")));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(contentHash(server.scene()), content);
}

TEST_F(Residues, ThatAnEditTakesAwayComeBack) {
  server.bake("cup", moved(0.01F));
  ASSERT_TRUE(
      editor.submit(parsed("operations { set_deformation { object { name: 'cup' } deformation { residue { } } } }")));
  EXPECT_FALSE(residue());
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(residue(), hashOf(moved(0.01F)));
  ASSERT_TRUE(editor.redo());
  EXPECT_FALSE(residue());
}

}  // namespace
}  // namespace haptics::residue_test
