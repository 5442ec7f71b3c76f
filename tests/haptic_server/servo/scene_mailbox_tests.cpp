#include <gtest/gtest.h>

#include <thread>

#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/servo/scene_mailbox.h"

namespace haptics::scene_mailbox_tests {
namespace {

std::unique_ptr<const ServoScene> sceneWithRevision(std::uint64_t revision,
                                                    std::shared_ptr<const ExplorationPlan> plan) {
  auto scene = std::make_unique<ServoScene>();
  scene->revision = revision;
  scene->plan = std::move(plan);
  return scene;
}

TEST(SceneMailbox, HandsOverTheNewestAndFreesWhatWasNeverAdopted) {
  SceneMailbox mailbox;
  EXPECT_EQ(mailbox.newest(), nullptr);
  auto first = std::make_shared<const ExplorationPlan>();
  mailbox.publish(sceneWithRevision(1, first));
  mailbox.publish(sceneWithRevision(2, nullptr));
  EXPECT_EQ(first.use_count(), 1);
  const ServoScene* scene = mailbox.newest();
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->revision, 2U);
  EXPECT_EQ(mailbox.newest(), nullptr);
}

TEST(SceneMailbox, KeepsTheOldSceneUntilTheServoHasLeftIt) {
  SceneMailbox mailbox;
  auto oldPlan = std::make_shared<const ExplorationPlan>();
  mailbox.publish(sceneWithRevision(1, oldPlan));
  (void)mailbox.newest();
  mailbox.adopted();
  mailbox.publish(sceneWithRevision(2, nullptr));
  mailbox.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 2) << "published, not adopted";
  (void)mailbox.newest();
  mailbox.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 2) << "taken, the old one still in use";
  mailbox.adopted();
  mailbox.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 1);
}

TEST(SceneMailbox, NeverShowsTheServoAFreedOrOlderScene) {
  constexpr std::uint64_t kScenes = 20'000;
  SceneMailbox mailbox;
  std::thread builder([&] {
    for (std::uint64_t revision = 1; revision <= kScenes; ++revision)
      mailbox.publish(sceneWithRevision(revision, nullptr));
  });
  const ServoScene* current = nullptr;
  std::uint64_t last = 0;
  while (last < kScenes) {
    if (const ServoScene* next = mailbox.newest()) {
      ASSERT_GT(next->revision, last);
      if (current) {
        ASSERT_EQ(current->revision, last);
      }
      current = next;
      last = next->revision;
      mailbox.adopted();
    }
  }
  builder.join();
}

}  // namespace
}  // namespace haptics::scene_mailbox_tests
