#include <gtest/gtest.h>

#include <thread>

#include "common/clock/monotonic.h"
#include "common/mesh/generators.h"
#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "haptic_server/servo/servo_loop.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::servo_loop_tests {
namespace {

/// Moves up and down through z = 0 and counts what it is asked.
class FakeDevice : public Device {
 public:
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override {
    ++reads;
    return {Vec3(0.001, 0.002, 0.003 * std::cos(0.05 * static_cast<double>(tick))), DeviceState::kReady};
  }
  void write(Vec3 force_N) noexcept override { largest_N = std::max(largest_N, glm::length(force_N)); }
  void stop() noexcept override { stopped = true; }

  std::uint64_t reads = 0;
  double largest_N = 0;
  bool stopped = false;

 private:
  DeviceInfo info_{"fake", 2.0, 0, 0, 0};
};

TEST(ServoLoop, RunsEveryPeriodOnceOrCountsItAsMissedAndStopsTheDevice) {
  FakeDevice device;
  SceneMailbox mailbox;
  mailbox.publish(fixture::sceneOf(
      7, {fixture::objectOf(1, fixture::surfaceOf(makeBox(Vec3(0.1), 2).value()), Vec3(0, 0, -0.05), 2000)}));
  ServoLoop loop(device, mailbox, 2000);
  const std::atomic<bool> stop{false};
  const std::uint64_t allocations = AllocationTripwire::count();
  loop.run(stop, 1000);

  const ServoStatistics& s = loop.statistics();
  EXPECT_EQ(s.ticks.load(), device.reads);
  EXPECT_EQ(s.adoptedRevision.load(), 7U);
  EXPECT_TRUE(loop.hand().statistics().contactTicks.load() > 0 || s.missedTicks.load() > 500);
  EXPECT_EQ(loop.hand().statistics().maxForce_N.load(), device.largest_N);
  EXPECT_LE(device.largest_N, 2.0 + 1e-12);
  EXPECT_TRUE(device.stopped);
  EXPECT_EQ(AllocationTripwire::count(), allocations);

  std::uint64_t popped = 0, last = 0;
  for (TelemetrySample sample; loop.hand().pop(sample); ++popped) {
    if (popped > 0) {
      EXPECT_GT(sample.tick, last);
    }
    last = sample.tick;
  }
  EXPECT_EQ(popped, s.ticks.load());
  EXPECT_EQ(s.ticks.load() + s.missedTicks.load(), last + 1);
  EXPECT_GE(last + 1, 1000U);
}

TEST(ServoLoop, TellsWhereBodiesAreAsLongAsTheyMove) {
  FakeDevice device;
  SceneMailbox mailbox;
  std::vector<ServoObject> objects{
      fixture::objectOf(3, fixture::surfaceOf(makeBox(Vec3(0.1), 2).value()), Vec3(0.5, 0, 1), 2000)};
  auto body = std::make_shared<RigidBody>();
  body->mass.mass_kg = 0.1;
  objects.front().motion = body;
  mailbox.publish(fixture::sceneOf(1, objects));
  ServoLoop loop(device, mailbox, 2000);
  const std::atomic<bool> stop{false};
  while (loop.statistics().ticks.load() < 20) loop.run(stop, 20);
  const MotionState* motion = loop.hand().takeMotion();
  ASSERT_NE(motion, nullptr);
  ASSERT_EQ(motion->bodyCount, 1U);
  EXPECT_EQ(motion->body[0].object, 3U);
  EXPECT_LT(motion->body[0].pose.position.z, 1) << "it falls";
  EXPECT_EQ(motion->body[0], loop.hand().lastMotion().body[0]);
  TelemetrySample last;
  while (loop.hand().pop(last)) {
  }
  EXPECT_EQ(motion->tick, last.tick);
  EXPECT_EQ(loop.hand().takeMotion(), nullptr);
  ASSERT_NE(loop.hand().takeMotionForBuilder(), nullptr);
}

TEST(ServoLoop, DropsAndCountsSamplesThatNobodyTakes) {
  FakeDevice device;
  SceneMailbox mailbox;
  ServoLoop loop(device, mailbox, 20'000);
  const std::atomic<bool> stop{false};
  while (loop.statistics().ticks.load() <= ServoHand::kQueuedSamples + 100) loop.run(stop, 2000);
  EXPECT_EQ(loop.hand().statistics().droppedSamples.load(), loop.statistics().ticks.load() - ServoHand::kQueuedSamples);
}

/// Comes down into z < 0 once and stays there.
class PressingDevice final : public FakeDevice {
 public:
  [[nodiscard]] DeviceReading read(std::uint64_t) noexcept override {
    depth_ = std::min(depth_ + 1e-4, 0.002);
    return {Vec3(0.001, 0.002, -depth_), DeviceState::kReady};
  }

 private:
  double depth_ = -0.003;
};

TEST(ServoLoop, KeepsItsSceneUntilTheContactThatTheNextOneBreaksIsLetGoAndThenTakesTheNewest) {
  const auto box = fixture::surfaceOf(makeBox(Vec3(0.1), 2).value());
  const auto boxAt = [&](std::uint64_t revision, double z) {
    auto scene = fixture::sceneOf(revision, {fixture::objectOf(1, box, Vec3(0, 0, z), 1000)});
    scene->plan = std::make_shared<const ExplorationPlan>();
    return scene;
  };
  PressingDevice device;
  SceneMailbox mailbox;
  ServoLoop loop(device, mailbox, 2000);
  const std::atomic<bool> stop{false};
  auto held = boxAt(1, -0.05);
  const std::weak_ptr<const ExplorationPlan> heldPlan = held->plan;
  mailbox.publish(std::move(held));
  while (loop.hand().statistics().contactTicks.load() < 30) loop.run(stop, 10);  // a loaded machine misses ticks
  const std::uint64_t missed = loop.statistics().missedTicks.load();
  mailbox.publish(boxAt(2, -0.3));
  loop.run(stop, 10);
  mailbox.publish(boxAt(3, -0.4));
  loop.run(stop, 10);
  EXPECT_EQ(loop.statistics().adoptedRevision.load(), 1U);
  EXPECT_FALSE(heldPlan.expired()) << "still in use";
  while (loop.statistics().adoptedRevision.load() == 1) loop.run(stop, 10);
  EXPECT_EQ(loop.statistics().adoptedRevision.load(), 3U);
  if (loop.statistics().missedTicks.load() == missed) {  // a fault would let go sooner
    EXPECT_GT(loop.hand().statistics().contactTicks.load(), 100U);
  }
  mailbox.reclaim();
  EXPECT_TRUE(heldPlan.expired());
  TelemetrySample sample;
  std::uint64_t revision = 1;
  while (loop.hand().pop(sample)) {
    EXPECT_TRUE(sample.sceneRevision == 3 || sample.sceneRevision == revision);
    revision = sample.sceneRevision;
  }
}

TEST(ServoLoop, StopsWhenAsked) {
  FakeDevice device;
  SceneMailbox mailbox;
  ServoLoop loop(device, mailbox, 1000);
  std::atomic<bool> stop{false};
  std::thread servo([&] { loop.run(stop); });
  while (loop.statistics().ticks.load() < 10) std::this_thread::yield();
  stop = true;
  servo.join();
  EXPECT_TRUE(device.stopped);
}

/// Is late once; then three ticks, of which the recorded servo slept through two between the last ones.
class FakeScript final : public ReplaySource {
 public:
  explicit FakeScript(const ServoScene& scene) : scene_(scene) {}
  [[nodiscard]] Next next(Tick& tick) noexcept override {
    switch (asked_++) {
      case 0:
        return Next::kNotYet;
      case 1:
        tick = {40, &scene_};
        return Next::kTick;
      case 2:
        tick = {41, nullptr};
        return Next::kTick;
      case 3:
        tick = {44, nullptr};
        return Next::kTick;
      default:
        return Next::kEnd;
    }
  }
  void releaseBefore(std::uint64_t scene) noexcept override { used.push_back(scene); }

  std::vector<std::uint64_t> used;

 private:
  const ServoScene& scene_;
  int asked_ = 0;
};

TEST(ServoLoop, RunsTheTicksOfAScriptInTheirTimeWithTheirScenes) {
  FakeDevice device;
  SceneMailbox mailbox;
  const auto scene = fixture::sceneOf(
      7, {fixture::objectOf(1, fixture::surfaceOf(makeBox(Vec3(0.1), 2).value()), Vec3(0, 0, -0.05), 2000)});
  ServoLoop loop(device, mailbox, 200);
  FakeScript script(*scene);
  const std::atomic<bool> stop{false};
  const std::uint64_t begin_ns = monotonicNow_ns();
  loop.run(script, stop);

  std::vector<TelemetrySample> samples(4);
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(loop.hand().pop(samples[i]));
  EXPECT_FALSE(loop.hand().pop(samples[3]));
  EXPECT_EQ(samples[0].tick, 40U);
  EXPECT_EQ(samples[0].sceneRevision, 7U);
  EXPECT_EQ(samples[2].tick, 44U);
  EXPECT_GE(samples[2].time_ns - begin_ns, 20'000'000U) << "four periods";
  EXPECT_EQ(samples[2].missedTicks, 2U);
  EXPECT_EQ(script.used.size(), 3U);
  EXPECT_TRUE(device.stopped);
}

}  // namespace
}  // namespace haptics::servo_loop_tests
