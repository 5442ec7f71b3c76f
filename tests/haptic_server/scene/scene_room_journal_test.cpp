#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "haptic_server/scene/scene_room.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics {
namespace {

using namespace test;
using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kPatience = 20s;  // of a test for another thread; never reached unless something is broken

/// Takes its time over the first edits until it is told to go on.
class SlowJournal final : public EditJournal {
 public:
  Result<void> keep(const SequencerState&, const Edits& edits, const Assets&) override {
    const bool first = batches.empty();
    batches.push_back(edits.size());
    if (first) {
      reached.set_value();
      goOn.get_future().wait_for(kPatience);
    }
    return {};
  }
  std::vector<std::size_t> batches;  ///< Edits in each.
  std::promise<void> reached, goOn;
};

class SceneRoomJournal : public ::testing::Test {
 protected:
  /// A state with one box, "a".
  SequencerState withABox() {
    sequencer_.submit(1, 1, edit(add("a")));
    return sequencer_.state();
  }
  static Result<std::string> boxBytes(const ContentHash&) { return encodeMesh(makeBox(Vec3(0.1), 1).value()); }
  std::future<void> submit(std::uint64_t seq, const Transaction& transaction) {
    auto replied = std::make_shared<std::promise<void>>();
    EXPECT_TRUE(room.submitEdit(7, seq, transaction, [replied](const EditOutcome&) { replied->set_value(); }));
    return replied->get_future();
  }

  SlowJournal journal;  // outlives the room
  SceneCrossing crossing;
  SceneRoom room{{}, crossing};

 private:
  BoxResolver resolver_;
  Sequencer sequencer_{5, resolver_};
};

TEST_F(SceneRoomJournal, GoesOnFromAState) {
  ASSERT_TRUE(room.resume(withABox(), boxBytes, journal));
  EXPECT_EQ(room.history()->epoch, 5U);
  EXPECT_EQ(room.history()->version.revision(), 1U);
  const ServoScene* scene = crossing.newest();
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->objects.size(), 1U);
}

TEST_F(SceneRoomJournal, SaysWhichObjectsMeshCannotBeHad) {
  const auto missing = room.resume(
      withABox(), [](const ContentHash&) { return refused("x", "is gone"); }, journal);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().text(), HasSubstr("\"a\": mesh: x: is gone"));
  const auto other = [](const ContentHash&) -> Result<std::string> { return encodeMesh(makeBox(Vec3(2), 1).value()); };
  const auto damaged = room.resume(withABox(), other, journal);
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().text(), HasSubstr("damaged"));
}

TEST_F(SceneRoomJournal, NobodyHearsOfAnEditBeforeItIsKept) {
  ASSERT_TRUE(room.resume(withABox(), boxBytes, journal));
  ASSERT_NE(crossing.newest(), nullptr);
  room.start();
  auto replied = submit(1, edit(moveTo("a", {1, 0, 0})));
  ASSERT_EQ(journal.reached.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(replied.wait_for(20ms), std::future_status::timeout);
  EXPECT_EQ(room.history()->version.revision(), 1U);
  EXPECT_EQ(crossing.newest(), nullptr) << "the servo has nothing new";
  journal.goOn.set_value();
  EXPECT_EQ(replied.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(room.history()->version.revision(), 2U);
}

TEST_F(SceneRoomJournal, EditsThatWaitAreKeptTogetherButNotThoseThatMakeMeshes) {
  ASSERT_TRUE(room.resume(withABox(), boxBytes, journal));
  room.start();
  std::vector<std::future<void>> replies;
  replies.push_back(submit(1, edit(moveTo("a", {1, 0, 0}))));
  ASSERT_EQ(journal.reached.get_future().wait_for(kPatience), std::future_status::ready);
  for (std::uint64_t seq = 2; seq <= 5; ++seq) replies.push_back(submit(seq, edit(moveTo("a", {double(seq), 0, 0}))));
  replies.push_back(submit(6, edit(add("b"))));
  for (std::uint64_t seq = 7; seq <= 6 + SceneRoom::kMaxBatch + 1; ++seq) {
    replies.push_back(submit(seq, edit(moveTo("a", {double(seq), 0, 0}))));
  }
  journal.goOn.set_value();
  for (auto& replied : replies) ASSERT_EQ(replied.wait_for(kPatience), std::future_status::ready);
  EXPECT_THAT(journal.batches, ElementsAre(1, 4, 1, SceneRoom::kMaxBatch, 1));
}

}  // namespace
}  // namespace haptics
