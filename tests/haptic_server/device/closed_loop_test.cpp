#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "haptic_server/device/exploring_hand.h"
#include "haptic_server/device/simulated_device.h"
#include "tests/haptic_server/device/analytic_scene.h"

// Device, hand and a force law without dissipation in closed loop, in virtual time at 1 kHz.
namespace haptics::test::closed_loop_test {
namespace {

constexpr double kPeriod = 1e-3;  // s

struct Loop {
  Loop(const DevicePreset& preset, const HandPreset& handPreset, AnalyticScene world, double delay_s = 0)
      : scene(std::move(world)),
        plan(scene.plan()),
        hand(handPreset, preset.maxForce_N),
        device({preset, handPreset, kPeriod, delay_s}, hand) {
    device.follow(&plan);
  }

  Vec3 tick() {
    hip = device.read(ticks++).position;
    force = scene.force(hip);
    device.write(force);
    return force;
  }

  AnalyticScene scene;
  ExplorationPlan plan;
  ExploringHand hand;
  SimulatedDevice device;
  std::uint64_t ticks = 0;
  Vec3 hip{0}, force{0};
};

DevicePreset omni() { return findDevicePreset("omni").value(); }
HandPreset nominal() { return findHandPreset("nominal").value(); }

AnalyticScene twoObjects() { return {{sphere(1, {-0.1, 0, 0.05}, 0.05), box(2, {0.1, 0, 0.03}, {0.04, 0.04, 0.03})}}; }

std::string nameOf(const DevicePreset& device, const HandPreset& hand) {
  return std::string(device.name) + ' ' + std::string(hand.name);
}

TEST(ClosedLoop, PressesToTheTargetForceWithEveryDeviceAndHand) {
  for (const DevicePreset& device : devicePresets()) {
    for (const HandPreset& hand : handPresets()) {
      if (hand.stiffness_N_per_m == 0) continue;
      Loop loop(device, hand, {{ground(1, 0)}});
      std::vector<double> pressed;
      for (int contact = 0; contact < 3000 && loop.ticks < 10000;) {
        const double force = glm::length(loop.tick());
        if (force > 0) ++contact;
        if (contact > 2000) pressed.push_back(force);
      }
      ASSERT_FALSE(pressed.empty()) << nameOf(device, hand);
      const auto [least, most] = std::ranges::minmax(pressed);
      EXPECT_GT(least, 0.8 * loop.hand.targetForce_N()) << nameOf(device, hand);
      EXPECT_LT(most, 1.2 * loop.hand.targetForce_N()) << nameOf(device, hand);
    }
  }
}

/// A hand that pushes, and does nothing else.
struct PushingHand final : HandIntent {
  Vec3 push{0};
  HandTarget next(double, Vec3) noexcept override { return {Vec3(0), push}; }
};

// N/m, below the stiffness at which a bare wall at 1 kHz destabilises the most delicate preset with no hand (the
// Phantom Premium, near 600 N/m).
constexpr double kSafeStiffness = 300;

TEST(ClosedLoop, RestsOnASafeWallWithEveryDeviceAndHand) {
  for (const DevicePreset& device : devicePresets()) {
    for (const HandPreset& hand : handPresets()) {
      PushingHand pushing;
      pushing.push = {0, 0, -1};
      SimulatedDevice simulated({device, hand, kPeriod}, pushing);
      const AnalyticScene wall{{ground(1, -0.001)}, kSafeStiffness};
      double lowest = 0, least = 1, most = -1;
      for (std::uint64_t tick = 0; tick < 6000; ++tick) {
        const double z = simulated.read(tick).position.z;
        simulated.write(wall.force({0, 0, z}));
        lowest = std::min(lowest, z);
        if (tick >= 5000) least = std::min(least, z), most = std::max(most, z);
      }
      EXPECT_GT(lowest, -0.012) << nameOf(device, hand);  // dropped on it: twice the static depth
      EXPECT_LE(most - least, std::max(2 * device.resolution_m, 20e-6) * 1.001) << nameOf(device, hand);
    }
  }
}

TEST(ClosedLoop, ExploresTwoObjectsMostOfTheTime) {
  for (const DevicePreset& device : devicePresets()) {
    Loop loop(device, nominal(), twoObjects());
    int contact = 0;
    double strongest = 0, largestStep = 0;
    Vec3 last(0);
    bool onSphere = false, onBox = false;
    while (loop.ticks < 20000) {
      const Vec3 force = loop.tick();
      const double magnitude = glm::length(force);
      if (magnitude > 0) {
        ++contact;
        (loop.hip.x < 0 ? onSphere : onBox) = true;
      }
      strongest = std::max(strongest, magnitude);
      largestStep = std::max(largestStep, glm::distance(force, last));
      last = force;
    }
    EXPECT_GE(contact, 9000) << device.name;
    EXPECT_TRUE(onSphere && onBox) << device.name;
    EXPECT_LT(strongest, 3) << device.name;
    EXPECT_LT(largestStep, 0.3) << device.name;  // 0.2 m/s into 800 N/m gives 0.16 N a tick; bouncing would give more
  }
}

TEST(ClosedLoop, StaysGentleUnderADelayOfATick) {
  Loop loop(omni(), nominal(), twoObjects(), kPeriod);
  double strongest = 0;
  while (loop.ticks < 10000) strongest = std::max(strongest, glm::length(loop.tick()));
  EXPECT_GT(strongest, 1.6);
  EXPECT_LT(strongest, 3);
}

TEST(ClosedLoop, LeavesAnObjectThatVanishesUnderIt) {
  Loop loop(omni(), nominal(), twoObjects());
  int rubbed = 0;
  while (rubbed < 1500 && loop.ticks < 10000) rubbed += glm::length(loop.tick()) > 1 ? 1 : 0;
  ASSERT_LT(loop.hip.x, 0);
  loop.scene.solids.erase(loop.scene.solids.begin());  // nobody tells the hand
  const std::uint64_t vanished = loop.ticks;
  double lowest = 1;
  while (loop.hip.x < 0 && loop.ticks < vanished + 5000) {
    loop.tick();
    lowest = std::min(lowest, loop.hip.z);
  }
  EXPECT_LT(loop.ticks, vanished + 3000);
  EXPECT_GT(lowest, 0.05);
  while (glm::length(loop.force) == 0 && loop.ticks < vanished + 8000) loop.tick();
  EXPECT_GT(loop.hip.x, 0);
}

TEST(ClosedLoop, RepeatsItselfBitForBit) {
  Loop a(omni(), nominal(), twoObjects()), b(omni(), nominal(), twoObjects());
  for (int i = 0; i < 8000; ++i) {
    ASSERT_EQ(a.tick(), b.tick());
    ASSERT_EQ(a.hip, b.hip);
  }
}

}  // namespace
}  // namespace haptics::test::closed_loop_test
