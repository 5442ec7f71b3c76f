#include "haptic_server/scene/edit_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "haptic_server/scene/sequencer.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::edit_journal_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr SessionId kAlice = 11;
constexpr SessionId kBob = 12;

/// Remembers what it was given, or refuses it.
class FakeJournal final : public EditJournal {
 public:
  Result<void> keep(const SequencerState& before, const Edits& edits, const Assets& assets) override {
    revisionsBefore.push_back(before.history->version.revision());
    if (failing) return refused("state", "the disk is full");
    batches.push_back(edits);
    for (const auto& asset : assets) kept.push_back(asset->name.hash);
    return {};
  }
  void resetTo(const SequencerState& state, const Assets&) override { wentOnFrom.push_back(state); }
  bool failing = false;
  std::vector<SequencerState> wentOnFrom;
  std::vector<std::uint64_t> revisionsBefore;
  std::vector<Edits> batches;
  std::vector<ContentHash> kept;
};

class JournaledSequencer : public ::testing::Test {
 protected:
  JournaledSequencer() {
    Sequencer earlier(5, resolver);
    sequencer.resume(earlier.state(), {}, journal);
  }
  std::vector<EditOutcome> submit(const std::vector<Submission>& submissions) { return sequencer.submit(submissions); }
  [[nodiscard]] const SceneVersion& version() const { return sequencer.history()->version; }

  BoxResolver resolver;
  FakeJournal journal;
  Sequencer sequencer{1, resolver};
};

TEST_F(JournaledSequencer, KeepsABatchTogetherBeforeItCounts) {
  const auto outcomes = submit({{kAlice, 1, edit(add("a"))}, {kBob, 1, edit(add("a"))}, {kBob, 2, edit(add("b"))}});
  ASSERT_THAT(outcomes, SizeIs(3));
  EXPECT_EQ(std::get<Error>(outcomes[1]).field, "operations[0].add.name") << "the first edit is there for the second";
  ASSERT_THAT(journal.batches, SizeIs(1));
  EXPECT_THAT(journal.batches[0], ElementsAre(std::get<Accepted>(outcomes[0]), std::get<Accepted>(outcomes[2])));
  EXPECT_THAT(journal.revisionsBefore, ElementsAre(0U));
  EXPECT_THAT(journal.kept, ElementsAre(version().find("a")->mesh, version().find("b")->mesh));
  EXPECT_EQ(journal.batches[0][1]->nextId, sequencer.state().nextId);
  EXPECT_EQ(version().revision(), 2U);
}

TEST_F(JournaledSequencer, HasNothingToKeepForWhatIsNotAccepted) {
  submit({{kAlice, 1, edit(remove("a"))}});
  EXPECT_THAT(journal.revisionsBefore, SizeIs(0));
}

TEST_F(JournaledSequencer, AnEditThatIsSentTwiceInABatchIsAppliedOnce) {
  const auto outcomes = submit({{kAlice, 1, edit(add("a"))}, {kAlice, 1, edit(add("a"))}});
  EXPECT_EQ(std::get<Accepted>(outcomes[0]), std::get<Accepted>(outcomes[1]));
  EXPECT_EQ(version().revision(), 1U);
}

TEST_F(JournaledSequencer, ABatchThatIsNotKeptLeavesNoTrace) {
  const auto known = std::get<Accepted>(submit({{kAlice, 1, edit(add("a"))}})[0]);
  const auto before = sequencer.history();
  journal.failing = true;
  Transaction stale = edit(moveTo("a", {2, 0, 0}));
  stale.preconditions.push_back({named("a"), 1, {}});
  const auto outcomes = submit({{kAlice, 1, edit(add("a"))},
                                {kBob, 1, edit(remove("nobody"))},
                                {kAlice, 2, edit(moveTo("a", {1, 0, 0}))},
                                {kBob, 2, stale},
                                {kBob, 3, edit(add("b"))}});
  EXPECT_EQ(std::get<Accepted>(outcomes[0]), known) << "was kept long ago";
  EXPECT_EQ(std::get<Error>(outcomes[1]).field, "operations[0].remove.object") << "rests on nothing of the batch";
  EXPECT_EQ(std::get<Error>(outcomes[2]).field, "state");
  EXPECT_EQ(std::get<Error>(outcomes[3]).field, "state") << "its conflict was with an edit that never was";
  EXPECT_EQ(std::get<Error>(outcomes[4]).field, "state");
  EXPECT_EQ(sequencer.history(), before);

  journal.failing = false;
  const auto again = submit({{kAlice, 2, edit(moveTo("a", {1, 0, 0}))}, {kBob, 3, edit(add("b"))}});
  EXPECT_EQ(std::get<Accepted>(again[0])->commit.revision, 2U) << "what was rejected is not remembered";
  EXPECT_EQ(std::get<Accepted>(again[1])->commit.put[0].id, known->commit.put[0].id + 1);
  EXPECT_NE(sequencer.assetsOf(known->commit.put[0].id).mesh, nullptr);
}

TEST_F(JournaledSequencer, ASampleInABatchThatIsNotKeptIsNotAnsweredAsTaken) {
  const auto known = std::get<Accepted>(submit({{kAlice, 1, edit(add("a"))}})[0]);
  const Transaction sample = edit(SetPose{named("a"), {Vec3(0, 0, 1), std::nullopt}, true});
  journal.failing = true;
  const auto outcomes = submit({{kAlice, 2, sample}, {kBob, 1, edit(add("b"))}});
  EXPECT_EQ(std::get<Error>(outcomes[0]).field, "state");
  EXPECT_EQ(sequencer.kinematicOf(known->commit.put[0].id), KinematicPose{});
  EXPECT_TRUE(std::holds_alternative<Accepted>(submit({{kAlice, 2, sample}})[0])) << "alone it has nothing to keep";
  EXPECT_EQ(sequencer.kinematicOf(known->commit.put[0].id).pose.position, Vec3(0, 0, 1));
}

}  // namespace
}  // namespace haptics::edit_journal_test
