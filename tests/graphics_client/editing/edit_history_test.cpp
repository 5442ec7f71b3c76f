#include "graphics_client/editing/edit_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::edit_history_test {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// Empty: it was done.
std::string refusalOf(const Result<void>& outcome) { return outcome ? "" : outcome.error().text(); }

class EditHistoryTest : public ::testing::Test {
 protected:
  EditHistoryTest() {
    for (const char* name : {"ball", "cup"}) EXPECT_TRUE(other.submit(addBox(name)));
  }

  [[nodiscard]] double stiffness(const std::string& name) const {
    return server.scene().find(name)->material.stiffness_N_per_m;
  }
  [[nodiscard]] double position(const std::string& name) const { return server.scene().find(name)->pose.position.x; }
  [[nodiscard]] std::string undoRefusal() const {
    const auto offer = editor.history.undoOffer();
    return offer && offer->refusal ? offer->refusal->text() : "";
  }

  EditServer server;
  Editor editor{server, 1}, other{server, 2};
};

TEST_F(EditHistoryTest, OffersNothingAtFirst) {
  EXPECT_FALSE(editor.history.undoOffer());
  EXPECT_FALSE(editor.history.redoOffer());
  EXPECT_EQ(refusalOf(editor.undo()), "there is nothing to undo");
  EXPECT_EQ(refusalOf(editor.redo()), "there is nothing to redo");
}

TEST_F(EditHistoryTest, SaysWhatWouldBeUndone) {
  editor.history.submit({moveTo("cup", 1), "Move cup"});
  EXPECT_FALSE(editor.history.undoOffer()) << "not accepted yet";
  editor.client.deliverAll();
  ASSERT_TRUE(editor.history.undoOffer());
  EXPECT_EQ(editor.history.undoOffer()->text, "Move cup");
  EXPECT_EQ(undoRefusal(), "");
}

TEST_F(EditHistoryTest, RefusesByNameToUndoWhatSomebodyElseChangedAndLosesNothingOfIt) {
  ASSERT_TRUE(editor.submit(moveTo("ball", 1)));
  ASSERT_TRUE(editor.submit(moveTo("cup", 2)));
  ASSERT_TRUE(editor.submit(setStiffness("ball", 300)));
  ASSERT_TRUE(other.submit(setStiffness("cup", 500)));

  ASSERT_TRUE(editor.undo());  // of the ball
  EXPECT_EQ(undoRefusal(), "object \"cup\": was changed by somebody else since; that is not overwritten");
  EXPECT_EQ(refusalOf(editor.undo()), undoRefusal());
  EXPECT_EQ(stiffness("cup"), 500);
  EXPECT_EQ(position("cup"), 2);

  editor.history.dropUndo();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("ball"), 0);
  EXPECT_EQ(stiffness("ball"), 800);
  EXPECT_EQ(stiffness("cup"), 500);
}

TEST_F(EditHistoryTest, RefusesToUndoOfSeveralObjectsAnyIfSomebodyElseRemovedOne) {
  v1::Transaction both = moveTo("ball", 1);
  both.MergeFrom(moveTo("cup", 2));
  ASSERT_TRUE(editor.submit(both));
  ASSERT_TRUE(other.submit(removal("cup")));
  EXPECT_THAT(refusalOf(editor.undo()), HasSubstr("\"cup\": was removed by somebody else"));
  EXPECT_EQ(position("ball"), 1);
}

TEST_F(EditHistoryTest, RefusesToAddAnObjectAgainWhoseNameSomebodyElseGave) {
  ASSERT_TRUE(editor.submit(removal("cup")));
  ASSERT_TRUE(other.submit(addBox("cup")));
  EXPECT_THAT(refusalOf(editor.undo()), HasSubstr("\"cup\": was added by somebody else"));
}

TEST_F(EditHistoryTest, UndoesWhatSomebodyElseChangedAndBroughtBack) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 2)));
  ASSERT_TRUE(other.submit(setStiffness("cup", 500)));
  EXPECT_NE(undoRefusal(), "");
  ASSERT_TRUE(other.undo());
  EXPECT_EQ(undoRefusal(), "");
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 0);
}

TEST_F(EditHistoryTest, KeepsAnEntryWhoseUndoIsInConflict) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 2)));
  std::optional<Result<v1::Accepted>> outcome;
  editor.history.undo([&](const auto& answer) { outcome = answer; });
  ASSERT_TRUE(other.submit(setStiffness("cup", 500)));  // comes before it
  editor.client.deliverAll();
  ASSERT_TRUE(outcome && !*outcome);
  EXPECT_EQ(outcome->error().field, "preconditions");
  EXPECT_THAT(outcome->error().reason, HasSubstr("stands at revision"));
  EXPECT_EQ(position("cup"), 2);
  EXPECT_EQ(stiffness("cup"), 500);
  ASSERT_TRUE(other.undo());
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 0);
}

TEST_F(EditHistoryTest, TakesBackNoPropertyThatSomebodyElseChangedWhileTheEditWasUnderWay) {
  editor.history.submit({moveTo("cup", 2), "Move cup"});
  ASSERT_TRUE(other.submit(setStiffness("cup", 500)));
  editor.client.deliverAll();
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 0);
  EXPECT_EQ(stiffness("cup"), 500);
}

TEST_F(EditHistoryTest, UndoesEditsThatWereUnderWayTogetherOneByOne) {
  editor.history.submit({moveTo("cup", 1), "first"});
  editor.history.submit({moveTo("cup", 2), "second"});
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 1);
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 0);
}

TEST_F(EditHistoryTest, WaitsForTheMirrorBeforeItUndoes) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  editor.client.holdMirror();
  ASSERT_TRUE(editor.submit(moveTo("cup", 2)));
  EXPECT_THAT(undoRefusal(), HasSubstr("has not come back from the server yet"));
  ASSERT_TRUE(editor.submit(moveTo("cup", 3)));
  ASSERT_TRUE(editor.submit(removal("ball")));
  editor.client.releaseMirror();
  ASSERT_TRUE(editor.undo());
  EXPECT_TRUE(server.scene().find("ball"));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(position("cup"), 2) << "before is the record that the mirror did not have yet";
}

TEST_F(EditHistoryTest, WaitsForAnEditThatIsUnderWayBeforeItUndoes) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  editor.history.submit({moveTo("ball", 1), "Move ball"});
  EXPECT_THAT(undoRefusal(), HasSubstr("on its way"));
  editor.client.deliverAll();
  EXPECT_EQ(undoRefusal(), "");
}

TEST_F(EditHistoryTest, RejectedEditIsReportedWithItsFieldAndIsNoEntry) {
  EXPECT_THAT(refusalOf(editor.submit(setStiffness("cup", -1))),
              HasSubstr("operations[0].set_material.material.stiffness_N_per_m: "));
  EXPECT_FALSE(editor.history.undoOffer());
}

TEST_F(EditHistoryTest, EditThatChangesNothingIsNoEntry) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 0)));
  EXPECT_FALSE(editor.history.undoOffer());
}

TEST_F(EditHistoryTest, NewEditLeavesNothingToRedo) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  ASSERT_TRUE(editor.undo());
  ASSERT_TRUE(editor.history.redoOffer());
  ASSERT_TRUE(editor.submit(moveTo("ball", 1)));
  EXPECT_FALSE(editor.history.redoOffer());
}

TEST_F(EditHistoryTest, UploadsAgainOnlyWhatTheServerDoesNotHoldAnyMore) {
  const ContentHash mesh = server.scene().find("cup")->mesh;
  ASSERT_TRUE(editor.submit(removal("cup")));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(server.uploads, 0U) << "the ball has the same mesh";
  ASSERT_TRUE(editor.redo());
  ASSERT_TRUE(editor.submit(removal("ball")));
  EXPECT_FALSE(server.holds(mesh));
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(server.uploads, 1U);
  EXPECT_EQ(server.scene().find("ball")->mesh, mesh);
}

TEST_F(EditHistoryTest, ForgetsTheOldestBeyondItsSize) {
  for (std::size_t i = 1; i <= EditHistory::kMaxEntries + 1; ++i) {
    ASSERT_TRUE(editor.submit(moveTo("cup", static_cast<double>(i) / 10)));
  }
  for (std::size_t i = 0; i < EditHistory::kMaxEntries; ++i) ASSERT_TRUE(editor.undo());
  EXPECT_FALSE(editor.history.undoOffer());
  EXPECT_EQ(position("cup"), 0.1);
}

TEST_F(EditHistoryTest, IsSavedUntilAnEditAndAgainWhereThatIsUndone) {
  EXPECT_TRUE(editor.history.isSaved());
  ASSERT_TRUE(other.submit(moveTo("ball", 1)));
  EXPECT_TRUE(editor.history.isSaved()) << "another's edit is not this user's to save";
  editor.history.submit({moveTo("cup", 1), "Move cup"});
  EXPECT_FALSE(editor.history.isSaved()) << "on its way";
  editor.client.deliverAll();
  EXPECT_FALSE(editor.history.isSaved());
  ASSERT_TRUE(editor.undo());
  EXPECT_TRUE(editor.history.isSaved());
  ASSERT_TRUE(editor.redo());
  EXPECT_FALSE(editor.history.isSaved());
  editor.history.markSaved(editor.history.state());
  EXPECT_TRUE(editor.history.isSaved());
  ASSERT_TRUE(editor.undo());
  EXPECT_FALSE(editor.history.isSaved()) << "the file has the edit";
}

TEST_F(EditHistoryTest, WhatIsSavedIsTheStateThatWasWritten) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  const std::uint64_t written = editor.history.state();
  ASSERT_TRUE(editor.submit(moveTo("cup", 2)));
  editor.history.markSaved(written);
  EXPECT_FALSE(editor.history.isSaved());
}

TEST_F(EditHistoryTest, AnEditThatIsSkippedIsStillInNoFile) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  editor.history.dropUndo();
  EXPECT_FALSE(editor.history.isSaved());
}

TEST_F(EditHistoryTest, AValueThatIsDraggedOnIsAnotherState) {
  const std::uint64_t group = editor.history.newGroup();
  for (const double stiffness : {300.0, 400.0}) {
    editor.history.submit({setStiffness("cup", stiffness), "Stiffness", {}, group});
    editor.client.deliverAll();
    EXPECT_FALSE(editor.history.isSaved());
    editor.history.markSaved(editor.history.state());
  }
}

/// One axis of a position, as a field of a panel sets it: the others are those of the view.
Edit shift(const std::string& name, int axis, double to_m) {
  const Composer compose = [=](const MirrorView& view) -> Result<v1::Transaction> {
    const auto object = view.scene->find(name);
    if (!object) return refused("object", "is not there any more");
    Vec3 place = object->pose.position;
    place[axis] = to_m;
    v1::Transaction transaction = moveTo(name, place.x);
    v1::Vector3& position = *transaction.mutable_operations(0)->mutable_set_pose()->mutable_pose()->mutable_position();
    position.set_y(place.y);
    position.set_z(place.z);
    return transaction;
  };
  return {.text = "shift", .compose = compose, .of = {name}};
}

TEST_F(EditHistoryTest, AnEditIsMadeOfWhatTheEditsBeforeItHaveLeft) {
  editor.client.holdMirror();
  editor.history.submit(shift("cup", 0, 1));
  editor.history.submit(shift("cup", 1, 2));
  editor.history.submit(shift("ball", 2, 3));
  EXPECT_EQ(editor.client.inFlight, 2U) << "another object's edit does not wait";
  editor.client.deliverAll();
  EXPECT_EQ(server.scene().find("cup")->pose.position, Vec3(1, 2, 0));
  EXPECT_EQ(server.scene().find("ball")->pose.position, Vec3(0, 0, 3));
  editor.history.submit(shift("cup", 2, 4));  // the mirror still has none of it
  editor.client.deliverAll();
  EXPECT_EQ(server.scene().find("cup")->pose.position, Vec3(1, 2, 4));
  editor.client.releaseMirror();
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(editor.undo());
  EXPECT_EQ(server.scene().find("cup")->pose.position, Vec3(0));
}

TEST_F(EditHistoryTest, AnEditOfWhatIsGoneByThenIsRefused) {
  std::vector<std::string> refusals;
  editor.history.submit({removal("cup"), "remove"});
  editor.history.submit(shift("cup", 0, 1),
                        [&](const auto& outcome) { refusals.push_back(outcome ? "" : outcome.error().text()); });
  editor.client.deliverAll();
  EXPECT_EQ(refusals, std::vector<std::string>{"object: is not there any more"});
  EXPECT_TRUE(editor.history.isSettled());
}

TEST_F(EditHistoryTest, UndoIsOfTheEditThatIsUnderWayNotOfTheOneBefore) {
  ASSERT_TRUE(editor.submit(moveTo("ball", 1)));
  editor.history.submit({setStiffness("cup", -1), "refused"});
  EXPECT_THAT(refusalOf(editor.undo()), HasSubstr("changed nothing"));
  EXPECT_EQ(position("ball"), 1);
  EXPECT_EQ(editor.history.undoOffer()->text, "edit");
}

TEST_F(EditHistoryTest, UndoIsOfTheEditBeforeItNotOfOneAfterIt) {
  editor.history.submit({moveTo("cup", 1), "first"});
  editor.history.undo();
  editor.history.submit({moveTo("ball", 2), "second"});
  editor.client.deliverAll();
  EXPECT_EQ(position("cup"), 0);
  EXPECT_EQ(position("ball"), 2);
  EXPECT_EQ(editor.history.undoOffer()->text, "second");
  EXPECT_FALSE(editor.history.redoOffer());
}

TEST_F(EditHistoryTest, UndoIsOfTheEditThatWasAskedForLastInWhateverOrderTheyAreAccepted) {
  editor.history.submit(shift("cup", 0, 1));
  editor.history.submit(shift("cup", 1, 2));
  editor.history.submit({removal("ball"), "remove"});  // passes the one before
  EXPECT_EQ(refusalOf(editor.undo()), "");
  EXPECT_TRUE(server.scene().find("ball"));
  EXPECT_EQ(server.scene().find("cup")->pose.position, Vec3(1, 2, 0));
  EXPECT_EQ(editor.history.redoOffer()->text, "remove");
  ASSERT_TRUE(editor.undo());
  EXPECT_EQ(server.scene().find("cup")->pose.position, Vec3(1, 0, 0));
}

TEST_F(EditHistoryTest, AnEditThatIsAcceptedLateIsInNoFileThatHasTheOnesAfterIt) {
  editor.history.submit(shift("cup", 0, 1));
  editor.history.submit(shift("cup", 1, 2));
  editor.history.submit({moveTo("ball", 1), "move"});
  editor.client.deliver();
  editor.client.deliver();
  ASSERT_EQ(position("ball"), 1);
  const std::uint64_t written = editor.history.state();
  editor.client.deliverAll();
  editor.history.markSaved(written);
  EXPECT_FALSE(editor.history.isSaved());
}

/// An edit of the cup that waits for its upload while others are accepted.
class OvertakenEditTest : public EditHistoryTest {
 protected:
  OvertakenEditTest() { history.submit({moveTo("cup", 1), "late", {std::make_shared<const TriMesh>()}}); }

  /// Then the upload has ended.
  void deliver() {
    editor.client.deliverAll();
    v1::AssetUploadReply reply;
    reply.set_accepted(true);
    if (const auto finished = std::exchange(upload.finished, nullptr)) finished(reply);
    editor.client.deliverAll();
  }
  void undo() {
    history.undo([this](const auto& outcome) { refusal = outcome ? "" : outcome.error().text(); });
  }
  static EditPort with(EditPort port, UploadCallbacks& upload) {
    port.upload = [&upload](const AssetContent&, UploadCallbacks callbacks) { upload = std::move(callbacks); };
    return port;
  }

  UploadCallbacks upload;
  EditHistory history{with(editor.client.port(), upload)};
  std::string refusal = "none asked";
};

TEST_F(OvertakenEditTest, UndoIsOfTheEditThatOvertookIt) {
  history.submit({moveTo("ball", 2), "quick"});
  editor.client.deliverAll();
  undo();
  deliver();
  EXPECT_EQ(refusal, "");
  EXPECT_EQ(position("ball"), 0);
  EXPECT_EQ(position("cup"), 1);
  undo();
  deliver();
  EXPECT_EQ(position("cup"), 0);
}

TEST_F(OvertakenEditTest, UndoOfItLetsEditsOfOtherObjectsPass) {
  undo();
  history.submit({setStiffness("cup", 500), "of the same object"});
  history.submit({moveTo("ball", 2), "of another"});
  editor.client.deliverAll();
  EXPECT_EQ(position("ball"), 2);
  EXPECT_EQ(stiffness("cup"), 800) << "comes after the undo";
  deliver();
  EXPECT_EQ(refusal, "");
  EXPECT_EQ(position("cup"), 0);
  EXPECT_EQ(stiffness("cup"), 500);
  EXPECT_EQ(history.undoOffer()->text, "of another");
  EXPECT_FALSE(history.redoOffer());
}

TEST_F(OvertakenEditTest, AnEditOfItsObjectThatOvertookItIsUndoneAfterIt) {
  history.submit({setStiffness("cup", 500), "quick"});
  undo();
  deliver();
  EXPECT_EQ(refusal, "object \"cup\": was changed since by \"late\", which was asked for before; undo that first");
  undo();
  undo();
  deliver();
  EXPECT_EQ(refusal, "");
  EXPECT_EQ(position("cup"), 0);
  EXPECT_EQ(stiffness("cup"), 800);
}

TEST_F(OvertakenEditTest, TurnsBehindItLetEditsOfOtherObjectsPassAndComeBeforeThem) {
  undo();
  history.redo();
  undo();
  history.redo();
  history.submit({moveTo("ball", 2), "of another"});
  editor.client.deliverAll();
  EXPECT_EQ(position("ball"), 2);
  deliver();
  EXPECT_EQ(position("cup"), 1);
  EXPECT_EQ(history.undoOffer()->text, "of another");
  undo();
  undo();
  deliver();
  EXPECT_EQ(refusal, "");
  EXPECT_EQ(position("ball"), 0);
  EXPECT_EQ(position("cup"), 0);
}

TEST_F(OvertakenEditTest, UndoAndRedoOfWhatWasBeforeItLetEditsOfOtherObjectsPass) {
  for (const char* name : {"plate", "jug"}) ASSERT_TRUE(other.submit(addBox(name)));
  history.submit({moveTo("plate", 3), "plate"});
  history.submit({moveTo("jug", 4), "jug"});
  editor.client.deliverAll();
  undo();
  undo();
  history.redo();
  history.submit({moveTo("ball", 2), "of another"});
  editor.client.deliverAll();
  EXPECT_EQ(position("ball"), 2) << "the turns wait for the edit of the cup";
  EXPECT_EQ(position("jug"), 4);
  deliver();
  EXPECT_EQ(position("jug"), 0);
  EXPECT_EQ(position("plate"), 3);
  EXPECT_EQ(history.undoOffer()->text, "of another");
}

TEST_F(EditHistoryTest, UndoOfADragWhoseLastValueIsUnderWayIsRedoneAndUndoneAgain) {
  const std::uint64_t group = editor.history.newGroup();
  editor.history.submit({moveTo("cup", 1), "drag", {}, group});
  editor.client.deliverAll();
  editor.history.submit({moveTo("cup", 2), "drag", {}, group});
  editor.history.undo();
  editor.history.redo();
  EXPECT_EQ(refusalOf(editor.undo()), "");
  EXPECT_EQ(position("cup"), 0);
  EXPECT_EQ(refusalOf(editor.redo()), "");
  EXPECT_EQ(position("cup"), 2);
}

TEST_F(OvertakenEditTest, NothingToUndoIsSaidAtOnce) {
  undo();
  undo();
  EXPECT_EQ(refusal, "there is nothing to undo");
}

TEST_F(EditHistoryTest, TellsWheneverItsOffersChange) {
  std::vector<bool> busy;
  EditPort port = editor.client.port();
  std::function<void()> changed;
  port.changed = [&changed] { changed(); };
  EditHistory history(std::move(port));
  changed = [&] { busy.push_back(!history.isSettled()); };
  history.submit({moveTo("cup", 1), "Move cup"});
  ASSERT_FALSE(busy.empty());
  EXPECT_TRUE(busy.back()) << "it may be undone at once";
  editor.client.deliverAll();
  EXPECT_FALSE(busy.back());
}

TEST_F(EditHistoryTest, AnUndoThatIsInVainTakesTheRedoBehindItAlong) {
  ASSERT_TRUE(editor.submit(moveTo("ball", 1)));
  ASSERT_TRUE(editor.undo());
  editor.history.submit({setStiffness("cup", -1), "refused"});
  editor.history.undo();
  editor.history.redo();
  editor.client.deliverAll();
  EXPECT_EQ(position("ball"), 0);
  EXPECT_TRUE(editor.history.isSettled());
}

TEST_F(EditHistoryTest, NothingIsUndoneInTheSceneThatARestartedServerBegins) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  const EditServer restarted({}, 8);
  ASSERT_TRUE(restarted.scene().objects().empty());
  editor.client.showMirror(restarted.mirrored());
  EXPECT_EQ(undoRefusal(), "the server has begun another scene since; there is nothing to undo in it");
  EXPECT_EQ(refusalOf(editor.undo()), undoRefusal());
  editor.history.submit({addBox("cup"), "add"});
  EXPECT_FALSE(editor.history.undoOffer());
}

TEST_F(EditHistoryTest, AnEditThatWasUnderWayAtARestartIsNoEntryAndHoldsUpNothing) {
  const EditServer restarted({}, 8);
  editor.history.submit({moveTo("cup", 1), "Move cup"});
  editor.client.showMirror(restarted.mirrored());
  editor.client.deliverAll();
  EXPECT_FALSE(editor.history.undoOffer());
  EXPECT_TRUE(editor.history.isSettled()) << "the new scene need not come to the old one's revision";
}

TEST_F(EditHistoryTest, ForgetsEverythingWithAnotherServer) {
  ASSERT_TRUE(editor.submit(moveTo("cup", 1)));
  editor.history.clear();
  EXPECT_FALSE(editor.history.undoOffer());
  EXPECT_TRUE(editor.history.isSaved());
}

}  // namespace
}  // namespace haptics::edit_history_test
