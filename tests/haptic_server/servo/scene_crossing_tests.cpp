#include <gtest/gtest.h>

#include <thread>

#include "haptic_server/servo/scene_crossing.h"

namespace haptics {
namespace {

std::unique_ptr<const ServoScene> sceneWithRevision(std::uint64_t revision,
                                                    std::shared_ptr<const ExplorationPlan> plan) {
  auto scene = std::make_unique<ServoScene>();
  scene->revision = revision;
  scene->plan = std::move(plan);
  return scene;
}

TEST(SceneCrossing, HandsOverTheNewestAndFreesWhatWasNeverAdopted) {
  SceneCrossing crossing;
  EXPECT_EQ(crossing.newest(), nullptr);
  auto first = std::make_shared<const ExplorationPlan>();
  crossing.publish(sceneWithRevision(1, first));
  crossing.publish(sceneWithRevision(2, nullptr));
  EXPECT_EQ(first.use_count(), 1);
  const ServoScene* scene = crossing.newest();
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->revision, 2U);
  EXPECT_EQ(crossing.newest(), nullptr);
}

TEST(SceneCrossing, KeepsTheOldSceneUntilTheServoHasLeftIt) {
  SceneCrossing crossing;
  auto oldPlan = std::make_shared<const ExplorationPlan>();
  crossing.publish(sceneWithRevision(1, oldPlan));
  (void)crossing.newest();
  crossing.adopted();
  crossing.publish(sceneWithRevision(2, nullptr));
  crossing.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 2) << "published, not adopted";
  (void)crossing.newest();
  crossing.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 2) << "taken, the old one still in use";
  crossing.adopted();
  crossing.reclaim();
  EXPECT_EQ(oldPlan.use_count(), 1);
}

TEST(SceneCrossing, NeverShowsTheServoAFreedOrOlderScene) {
  constexpr std::uint64_t kScenes = 20'000;
  SceneCrossing crossing;
  std::thread builder([&] {
    for (std::uint64_t revision = 1; revision <= kScenes; ++revision)
      crossing.publish(sceneWithRevision(revision, nullptr));
  });
  const ServoScene* current = nullptr;
  std::uint64_t last = 0;
  while (last < kScenes) {
    if (const ServoScene* next = crossing.newest()) {
      ASSERT_GT(next->revision, last);
      if (current) {
        ASSERT_EQ(current->revision, last);
      }
      current = next;
      last = next->revision;
      crossing.adopted();
    }
  }
  builder.join();
}

}  // namespace
}  // namespace haptics
