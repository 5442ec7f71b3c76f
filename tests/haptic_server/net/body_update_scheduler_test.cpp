#include "haptic_server/net/body_update_scheduler.h"

#include <gtest/gtest.h>

#include <set>

#include "common/wire/convert.h"
#include "common/wire/udp.h"

namespace haptics::body_update_scheduler_test {
namespace {

MotionState motionOf(std::size_t count) {
  MotionState motion;
  motion.bodyCount = count;
  for (std::size_t i = 0; i < count; ++i) motion.body[i].object = i + 1;
  return motion;
}

std::multiset<std::uint64_t> toldOf(BodyUpdateScheduler& turns, const MotionState& motion) {
  v1::Telemetry sample;
  turns.add(motion, sample);
  std::multiset<std::uint64_t> objects;
  for (const v1::BodyPose& body : sample.body()) objects.insert(body.object());
  return objects;
}

TEST(BodyUpdateScheduler, TellALateClientOfAllBodiesAFewAtATime) {
  BodyUpdateScheduler turns;
  const MotionState motion = motionOf(kMaxMovingBodies);
  std::set<std::uint64_t> told;
  for (std::size_t i = 0; i < kMaxMovingBodies / BodyUpdateScheduler::kMax; ++i) {
    const auto now = toldOf(turns, motion);
    EXPECT_EQ(now.size(), BodyUpdateScheduler::kMax);
    told.insert(now.begin(), now.end());
  }
  EXPECT_EQ(told.size(), kMaxMovingBodies);
}

TEST(BodyUpdateScheduler, TellOfEachThatMovesInEverySampleAndOfOneThatRestsInTurn) {
  BodyUpdateScheduler turns;
  MotionState motion = motionOf(6);
  (void)toldOf(turns, motion);
  std::multiset<std::uint64_t> told;
  for (int i = 1; i <= 40; ++i) {
    motion.body[0].pose.position.x = motion.body[3].pose.position.x = i;
    const auto now = toldOf(turns, motion);
    EXPECT_EQ(now.size(), 3U);
    told.insert(now.begin(), now.end());
  }
  EXPECT_EQ(told.count(1), 40U);
  EXPECT_EQ(told.count(4), 40U);
  for (const std::uint64_t resting : {2, 3, 5, 6}) EXPECT_EQ(told.count(resting), 10U) << resting;
}

TEST(BodyUpdateScheduler, TellOfMoreThanASampleHoldsByTurns) {
  BodyUpdateScheduler turns;
  MotionState motion = motionOf(12);
  std::multiset<std::uint64_t> told;
  for (int i = 1; i <= 30; ++i) {
    for (BodyState& body : motion.body) body.pose.position.x = i;
    const auto now = toldOf(turns, motion);
    told.insert(now.begin(), now.end());
  }
  for (std::uint64_t object = 1; object <= 12; ++object) EXPECT_EQ(told.count(object), 20U) << object;
}

TEST(BodyUpdateScheduler, ForgetThoseThatAreGone) {
  BodyUpdateScheduler turns;
  (void)toldOf(turns, motionOf(3));
  EXPECT_TRUE(toldOf(turns, motionOf(0)).empty());
  EXPECT_EQ(toldOf(turns, motionOf(3)).size(), 3U) << "news again";
}

TEST(BodyUpdateScheduler, KeepASampleWithinADatagram) {
  TelemetrySample sample;
  sample.tick = sample.time_ns = sample.object = sample.missedTicks = ~0ULL;
  sample.sceneRevision = sample.adoptionTick = sample.deformationRevision = sample.droppedSamples = ~0ULL >> 16;
  sample.hip = sample.ihip = sample.surfaceNormal = sample.stickingPoint = Vec3(-1.0 / 3);
  for (Vec3* force : {&sample.force.spring, &sample.force.damping, &sample.force.friction, &sample.force.texture,
                      &sample.force.contact, &sample.force.written}) {
    *force = Vec3(-1.0 / 3);
  }
  sample.energyGiven_J.fill(-1.0 / 3);
  sample.largestEnergySource = {1U << 20, EnergyFeature::kEdit, 1.0 / 3};
  sample.primitive = {PrimitiveKind::kVertex, 2, ~0U};
  MotionState motion = motionOf(kMaxMovingBodies);
  for (BodyState& body : motion.body) {
    body.object += 1U << 20;
    body.pose = {Quat(0.5, 0.5, 0.5, 0.5), Vec3(-1.0 / 3)};
    body.condition = BodyCondition::kAsleep;
  }
  BodyUpdateScheduler turns;
  v1::Datagram datagram;
  datagram.set_cookie(std::string(16, 'c'));
  toWire(sample, *datagram.mutable_telemetry());
  turns.add(motion, *datagram.mutable_telemetry());
  EXPECT_LE(datagram.ByteSizeLong(), kMaxDatagramBytes);
}

}  // namespace
}  // namespace haptics::body_update_scheduler_test
