#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "haptic_server/scene/scene_service.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::scene_service_journal_test {
namespace {

using namespace test;
using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto kPatience = 60s;  // of a test for another thread; never reached unless something is broken

/// Takes its time over the first edits until continueLog is set.
class SlowJournal final : public EditJournal {
 public:
  Result<void> keep(const SequencerState&, const Edits& edits, const Assets&) override {
    const bool first = batches.empty();
    batches.push_back(edits.size());
    if (first) {
      reached.set_value();
      continueLog.get_future().wait_for(kPatience);
    }
    return {};
  }
  void resetTo(const SequencerState& state, const Assets&) override { wentOnFrom.push_back(state); }
  std::vector<SequencerState> wentOnFrom;
  std::vector<std::size_t> batches;  ///< Edits in each.
  std::promise<void> reached, continueLog;
};

class SceneServiceJournal : public ::testing::Test {
 protected:
  /// A state with one box, "a".
  SequencerState withABox() {
    sequencer_.submit(1, 1, edit(add("a")));
    return sequencer_.state();
  }
  static Result<std::string> boxBytes(const ContentHash&) { return encodeMesh(makeBox(Vec3(0.1), 1).value()); }
  std::future<void> submit(std::uint64_t seq, const Transaction& transaction) {
    auto replied = std::make_shared<std::promise<void>>();
    EXPECT_TRUE(sceneService.submitEdit(7, seq, transaction, [replied](const EditOutcome&) { replied->set_value(); }));
    return replied->get_future();
  }

  SlowJournal journal;  // outlives the service
  SceneMailbox mailbox;
  SceneService sceneService{{}, mailbox};

 private:
  BoxResolver resolver_;
  Sequencer sequencer_{5, resolver_};
};

TEST_F(SceneServiceJournal, GoesOnFromAState) {
  ASSERT_THAT(sceneService.resume(withABox(), boxBytes, journal), IsEmpty());
  EXPECT_EQ(sceneService.history()->epoch, 5U);
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  const ServoScene* scene = mailbox.newest();
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->objects.size(), 1U);
}

TEST_F(SceneServiceJournal, AnObjectWhoseMeshCannotBeHadStaysAsAPlaceholder) {
  const auto missing = [](const ContentHash&) -> Result<std::string> { return refused("x", "is gone"); };
  SequencerState state = withABox();
  const ObjectRecord before = *state.history->version.find("a");
  EXPECT_THAT(sceneService.resume(std::move(state), missing, journal),
              ElementsAre(HasSubstr("\"a\": mesh: x: is gone")));
  EXPECT_THAT(sceneService.lostParts(), ElementsAre("a: mesh"));
  const auto history = sceneService.history();
  EXPECT_NE(history->epoch, 5U);
  EXPECT_EQ(history->version.revision(), 2U);
  EXPECT_EQ(history->version.find("a")->id, before.id);
  ASSERT_EQ(journal.wentOnFrom.size(), 1U);
  EXPECT_EQ(journal.wentOnFrom[0].history->version.root(), history->version.root());
  EXPECT_EQ(*journal.wentOnFrom[0].lost.at(0), before);
  EXPECT_EQ(mailbox.newest()->objects.size(), 1U);
}

TEST_F(SceneServiceJournal, BytesThatAreNotTheMeshAreNoMesh) {
  const auto other = [](const ContentHash&) -> Result<std::string> { return encodeMesh(makeBox(Vec3(2), 1).value()); };
  EXPECT_THAT(sceneService.resume(withABox(), other, journal), ElementsAre(HasSubstr("damaged")));
}

TEST_F(SceneServiceJournal, AnUploadGivesAnObjectItsMeshBack) {
  const auto missing = [](const ContentHash&) -> Result<std::string> { return refused("x", "is gone"); };
  SequencerState state = withABox();
  const ObjectRecord before = *state.history->version.find("a");
  (void)sceneService.resume(std::move(state), missing, journal);
  const std::uint64_t epoch = sceneService.history()->epoch;
  journal.continueLog.set_value();
  sceneService.start();
  std::promise<bool> replied;
  const std::string bytes = boxBytes({}).value();
  ASSERT_TRUE(sceneService.submitAsset(7, {AssetKind::kMesh, before.mesh}, bytes, [&](const auto& asset) {
    replied.set_value(asset.has_value() && sceneService.history()->version.find("a")->mesh == before.mesh);
  }));
  EXPECT_TRUE(replied.get_future().get());
  EXPECT_EQ(sceneService.history()->epoch, epoch);
  EXPECT_THAT(sceneService.lostParts(), IsEmpty());
  EXPECT_THAT(journal.batches, ElementsAre(1));
}

TEST_F(SceneServiceJournal, AStartSceneThatCannotBeKeptYetIsThereAllTheSame) {
  struct FullJournal final : EditJournal {
    Result<void> keep(const SequencerState&, const Edits&, const Assets&) override { return refused("state", "full"); }
    void resetTo(const SequencerState& state, const Assets& assets) override {
      revision = state.history->version.revision();
      held = assets.size();
    }
    std::uint64_t revision = 0;
    std::size_t held = 0;
  } full;
  SequencerState empty;
  empty.history = std::make_shared<const SceneHistory>(SceneHistory{5, {}, {}});
  (void)sceneService.resume(std::move(empty), boxBytes, full);
  ASSERT_TRUE(sceneService.loadStartScene(edit(AddObject{"a", box(), {}, {}})));
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  EXPECT_EQ(full.revision, 1U);
  EXPECT_EQ(full.held, 1U);
}

TEST_F(SceneServiceJournal, NobodyHearsOfAnEditBeforeItIsKept) {
  ASSERT_THAT(sceneService.resume(withABox(), boxBytes, journal), IsEmpty());
  ASSERT_NE(mailbox.newest(), nullptr);
  sceneService.start();
  auto replied = submit(1, edit(moveTo("a", {1, 0, 0})));
  ASSERT_EQ(journal.reached.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(replied.wait_for(20ms), std::future_status::timeout);
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  EXPECT_EQ(mailbox.newest(), nullptr) << "the servo has nothing new";
  journal.continueLog.set_value();
  EXPECT_EQ(replied.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(sceneService.history()->version.revision(), 2U);
}

TEST_F(SceneServiceJournal, EditsThatWaitAreKeptTogetherButNotThoseThatMakeMeshes) {
  ASSERT_THAT(sceneService.resume(withABox(), boxBytes, journal), IsEmpty());
  sceneService.start();
  std::vector<std::future<void>> replies;
  replies.push_back(submit(1, edit(moveTo("a", {1, 0, 0}))));
  ASSERT_EQ(journal.reached.get_future().wait_for(kPatience), std::future_status::ready);
  for (std::uint64_t seq = 2; seq <= 5; ++seq) replies.push_back(submit(seq, edit(moveTo("a", {double(seq), 0, 0}))));
  replies.push_back(submit(6, edit(add("b"))));
  for (std::uint64_t seq = 7; seq <= 6 + SceneService::kMaxBatch + 1; ++seq) {
    replies.push_back(submit(seq, edit(moveTo("a", {double(seq), 0, 0}))));
  }
  journal.continueLog.set_value();
  for (auto& replied : replies) ASSERT_EQ(replied.wait_for(kPatience), std::future_status::ready);
  EXPECT_THAT(journal.batches, ElementsAre(1, 4, 1, SceneService::kMaxBatch, 1));
}

TEST_F(SceneServiceJournal, AnUploadAtWhichTheServerDiedIsForAnotherSessionToTryAgain) {
  const TemporaryFolder folder;
  const TriMesh mesh = makeBox(Vec3(0.1), 1).value();
  const auto upload = [&](SceneService& service, SessionId session) {
    std::promise<Result<std::shared_ptr<const Asset>>> answered;
    EXPECT_TRUE(service.submitAsset(session, {AssetKind::kMesh, hashOf(mesh)}, encodeMesh(mesh),
                                    [&](auto outcome) { answered.set_value(std::move(outcome)); }));
    service.executeAll();
    return answered.get_future().get();
  };
  const std::filesystem::path file = folder / "at_work", left = folder / "left";
  {
    auto notes = WorkNotes::open(file);
    ASSERT_NE(notes, nullptr);
    notes->crashFlag() = 1;
    WorkNotes::Key key{7};
    std::memcpy(&key.second, hashOf(mesh).bytes.data(), sizeof key.second);
    const WorkNotes::UnderWay building(notes.get(), key);
    std::filesystem::copy_file(file, left);
  }
  sceneService.noteWorkIn(WorkNotes::open(left));
  const auto again = upload(sceneService, 7);
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().text(), HasSubstr("this session does not try it again"));
  EXPECT_TRUE(upload(sceneService, 8));
}

TEST_F(SceneServiceJournal, WhatTheServerDiedAtIsNotTriedAgain) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "at_work", left = folder / "left";
  const auto leave = [&] {
    std::filesystem::remove(left);  // another one may still be mapped
    std::filesystem::copy_file(file, left);
    return WorkNotes::open(left);
  };
  auto notes = WorkNotes::open(file);
  ASSERT_NE(notes, nullptr);
  { const WorkNotes::UnderWay done(notes.get(), {7, 1}); }
  const WorkNotes::UnderWay small(notes.get(), {7, 2});
  EXPECT_THAT(leave()->diedAt(), IsEmpty()) << "it was killed";
  notes->crashFlag() = 1;
  auto after = leave();
  EXPECT_THAT(after->diedAt(), ElementsAre(WorkNotes::Key{7, 2}));
  after.reset();
  after = WorkNotes::open(left);
  EXPECT_THAT(after->diedAt(), IsEmpty()) << "the one before";

  sceneService.noteWorkIn(std::move(after));
  sceneService.start();
  std::promise<EditOutcome> answered;
  ASSERT_TRUE(sceneService.submitEdit(7, 2, edit(add("poison")), [&](const EditOutcome& o) { answered.set_value(o); }));
  const EditOutcome outcome = answered.get_future().get();
  ASSERT_TRUE(std::holds_alternative<Error>(outcome));
  EXPECT_THAT(std::get<Error>(outcome).text(), HasSubstr("the server died, about the object \"poison\""));
  submit(3, edit(add("a"))).wait();
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  notes->endsInOrder();
  EXPECT_THAT(leave()->diedAt(), IsEmpty());
}

}  // namespace
}  // namespace haptics::scene_service_journal_test
