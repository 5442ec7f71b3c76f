#include "haptic_server/scene/session_lanes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace haptics::session_lanes_test {
namespace {

using ::testing::ElementsAre;
using Lanes = SessionLanes<std::string>;

constexpr SessionId kAlice = 1, kBob = 2;

class SessionLanesTest : public ::testing::Test {
 protected:
  void add(SessionId session, const std::string& task) { ASSERT_TRUE(lanes.add(session, 1, task)); }
  Lanes::Job take() { return lanes.take(); }
  /// All that may be taken now.
  std::vector<std::string> takeAll() {
    std::vector<std::string> tasks;
    while (lanes.next() != nullptr) {
      const auto job = lanes.take();
      tasks.push_back(job.task);
      lanes.finished(job);
    }
    return tasks;
  }
  Lanes lanes{10, 6};
};

TEST_F(SessionLanesTest, TakesJobsAsTheyCame) {
  add(kAlice, "a1");
  add(kBob, "b1");
  add(kAlice, "a2");
  EXPECT_EQ(lanes.next()->task, "a1");
  EXPECT_THAT(takeAll(), ElementsAre("a1", "b1", "a2"));
  EXPECT_EQ(lanes.bytes(), 0U);
}

TEST_F(SessionLanesTest, OnlyItsOwnSessionWaitsForWhatIsPrepared) {
  add(kAlice, "a1");
  add(kAlice, "a2");
  add(kBob, "b1");
  lanes.setAside(take());
  EXPECT_THAT(takeAll(), ElementsAre("b1"));
  auto job = lanes.takeAside();
  ASSERT_TRUE(job);
  EXPECT_FALSE(lanes.anyAside());
  add(kAlice, "a3");
  EXPECT_EQ(lanes.next(), nullptr);
  lanes.prepared(*std::move(job));
  add(kBob, "b2");
  EXPECT_THAT(takeAll(), ElementsAre("a1", "a2", "a3", "b2"));
}

TEST_F(SessionLanesTest, WhatWasTakenTooEarlyGoesBackInFront) {
  for (const char* task : {"a1", "a2", "a3"}) add(kAlice, task);
  auto first = take(), second = take();
  lanes.setAside(std::move(first));
  lanes.putBack(std::move(second));
  EXPECT_EQ(lanes.next(), nullptr);
  lanes.prepared(*lanes.takeAside());
  EXPECT_THAT(takeAll(), ElementsAre("a1", "a2", "a3"));
}

TEST_F(SessionLanesTest, WhatIsPutOffWaitsBesideWhatIsNew) {
  for (const SessionId session : {1, 2, 3, 4}) add(session, std::to_string(session));
  for (int i = 0; i < 4; ++i) lanes.setAside(take());
  auto first = lanes.takeAside(), second = lanes.takeAside();
  lanes.postpone(*std::move(second));
  lanes.postpone(*std::move(first));
  EXPECT_TRUE(lanes.anyPostponed());
  EXPECT_EQ(lanes.queued(2)->place, 2U);
  EXPECT_EQ(lanes.queued(2)->job->task, "2");
  EXPECT_EQ(lanes.queued(3)->place, 1U);
  EXPECT_FALSE(lanes.queued(5));
  EXPECT_EQ(lanes.takeAside()->task, "3");
  for (const char* task : {"1", "2", "4"}) EXPECT_EQ(lanes.takeAsideOrPostponed()->task, task);
  EXPECT_FALSE(lanes.takeAsideOrPostponed());
}

TEST_F(SessionLanesTest, WhatFollowsADroppedJobMayBeTaken) {
  add(kAlice, "a1");
  add(kAlice, "a2");
  lanes.setAside(take());
  const auto job = lanes.takeAside();
  lanes.finished(*job);
  EXPECT_THAT(takeAll(), ElementsAre("a2"));
  EXPECT_EQ(lanes.bytes(), 0U);
}

TEST_F(SessionLanesTest, IsFullAtItsBoundsUntilJobsAreFinished) {
  EXPECT_TRUE(lanes.add(kAlice, 7, "more than one session's, alone"));
  EXPECT_FALSE(lanes.add(kAlice, 1, "and one more"));
  EXPECT_TRUE(lanes.add(kBob, 3, "the rest"));
  EXPECT_FALSE(lanes.add(kBob, 1, "and one more"));
  lanes.setAside(take());
  EXPECT_FALSE(lanes.add(kBob, 1, "it is not finished"));
  lanes.finished(*lanes.takeAside());
  EXPECT_TRUE(lanes.add(kBob, 3, "up to its bound"));
  EXPECT_FALSE(lanes.add(kBob, 1, "beyond"));
  EXPECT_TRUE(lanes.add(kAlice, 4, "others have room"));
}

}  // namespace
}  // namespace haptics::session_lanes_test
