#include "graphics_client/editing/latest_edit.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::latest_edit_test {
namespace {

using namespace test;

constexpr int kValues = 1000;
constexpr int kValuesPerReply = 50;

class LatestEditTest : public ::testing::Test {
 protected:
  LatestEditTest() {
    EXPECT_TRUE(other.submit(addBox("cup")));
    EXPECT_TRUE(editor.submit(setStiffness("cup", 400)));
  }

  [[nodiscard]] double stiffness() const { return server.scene().find("cup")->material.stiffness_N_per_m; }
  LatestEdit drag() {
    return {editor.history, "Stiffness of cup", [this](const Result<v1::Accepted>& outcome) {
              if (!outcome) errors.push_back(outcome.error().field);
            }};
  }
  /// 401, 402, ... with a reply now and then.
  void burst(LatestEdit& edit) {
    for (int i = 1; i <= kValues; ++i) {
      edit.set({setStiffness("cup", 400 + i)});
      if (i % kValuesPerReply == 0) editor.client.deliver();
    }
  }

  EditServer server;
  Editor editor{server, 1}, other{server, 2};
  std::vector<std::string> errors;
};

TEST_F(LatestEditTest, BurstHasOneTransactionInFlightAndItsLastValueArrives) {
  const std::size_t before = editor.client.submitted;
  auto edit = std::optional(drag());
  burst(*edit);
  edit.reset();  // the mouse button is released
  editor.client.deliverAll();
  EXPECT_EQ(editor.client.mostInFlight, 1U);
  EXPECT_LE(editor.client.submitted - before, kValues / kValuesPerReply + 2);
  EXPECT_EQ(stiffness(), 400 + kValues);

  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 400) << "the drag is one entry";
  ASSERT_TRUE(editor.redo());
  EXPECT_EQ(stiffness(), 400 + kValues);
}

TEST_F(LatestEditTest, UndoThatIsPressedWhileTheLastValueWaitsIsOfTheDrag) {
  auto edit = std::optional(drag());
  edit->set({setStiffness("cup", 500)});
  edit->set({setStiffness("cup", 600)});
  edit.reset();
  editor.history.undo();
  editor.client.deliverAll();
  EXPECT_EQ(stiffness(), 400);
  ASSERT_TRUE(editor.redo());
  EXPECT_EQ(stiffness(), 600);
}

TEST_F(LatestEditTest, UndoThatIsPressedTwiceWhileTheLastValueWaitsIsOfTheDragAndOfTheEditBefore) {
  auto edit = std::optional(drag());
  edit->set({setStiffness("cup", 500)});
  edit->set({setStiffness("cup", 600)});
  edit.reset();
  editor.history.undo();
  editor.client.deliver();
  editor.history.undo();
  editor.client.deliverAll();
  EXPECT_EQ(stiffness(), 800);
}

TEST_F(LatestEditTest, TwoDragsAreTwoEntries) {
  auto first = drag(), second = drag();
  first.set({setStiffness("cup", 500)});
  editor.client.deliverAll();
  second.set({setStiffness("cup", 600)});
  editor.client.deliverAll();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 500);
}

TEST_F(LatestEditTest, DragBackToWhereItBeganIsNoEntry) {
  auto edit = drag();
  for (const double value : {500, 600, 400}) {
    edit.set({setStiffness("cup", value)});
    editor.client.deliverAll();
  }
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 800) << "that of before the drag is undone";
}

TEST_F(LatestEditTest, RejectedValueIsReportedWithItsFieldAndTheLastOneArrives) {
  auto edit = drag();
  edit.set({setStiffness("cup", 450)});
  editor.client.deliverAll();
  edit.set({setStiffness("cup", -1)});
  edit.set({setStiffness("cup", 500)});
  editor.client.deliverAll();
  EXPECT_EQ(errors, std::vector<std::string>{"operations[0].set_material.material.stiffness_N_per_m"});
  EXPECT_EQ(stiffness(), 500);
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 400);
}

TEST_F(LatestEditTest, RejectedLastValueLeavesTheLastAcceptedOneInTheHistory) {
  auto edit = drag();
  edit.set({setStiffness("cup", 450)});
  edit.set({setStiffness("cup", -1)});
  editor.client.deliverAll();
  EXPECT_EQ(errors.size(), 1U);
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 400);
  ASSERT_TRUE(editor.redo());
  EXPECT_EQ(stiffness(), 450);
}

TEST_F(LatestEditTest, LastValueArrivesAfterALostConnection) {
  const std::size_t before = editor.client.submitted;
  auto edit = drag();
  edit.set({setStiffness("cup", 401)});
  editor.client.loseConnection();  // with the reply to the first value
  burst(edit);
  EXPECT_EQ(stiffness(), 401);
  EXPECT_EQ(editor.client.submitted - before, 1U);
  editor.client.reconnect();
  editor.client.deliverAll();
  EXPECT_EQ(stiffness(), 400 + kValues);
  EXPECT_EQ(editor.client.submitted - before, 2U);
  EXPECT_EQ(editor.client.mostInFlight, 1U);
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 400);
}

TEST_F(LatestEditTest, UndoOfADragKeepsWhatSomebodyElseDidMeanwhile) {
  auto edit = drag();
  edit.set({setStiffness("cup", 450)});
  editor.client.deliverAll();
  ASSERT_TRUE(other.submit(moveTo("cup", 3)));
  edit.set({setStiffness("cup", 500)});
  editor.client.deliverAll();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(stiffness(), 400);
  EXPECT_EQ(server.scene().find("cup")->pose.position.x, 3);
}

}  // namespace
}  // namespace haptics::latest_edit_test
