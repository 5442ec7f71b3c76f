#include "haptic_server/device/leadable_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "haptic_server/device/simulated_device.h"

namespace haptics::leadable_hand_test {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr double kMaxForce_N = 3.3;
constexpr double kGroundAndHand_N_per_m = 1 / (1 / 800.0 + 1 / 300.0);

HandPreset nominal() { return findHandPreset("nominal").value(); }

HandCommand at(Vec3 position) { return {.leads = true, .position = position}; }
HandCommand pressing(Vec3 position, double press_N) { return {true, position, {0, 0, 1}, press_N}; }

/// A hand without inertia over a springy ground at z = 0; it counts how it moves.
struct Led {
  LeadableHand hand{nominal(), kMaxForce_N};
  Vec3 position = hand.next(0, Vec3(0)).position;
  Vec3 velocity{0};
  double force_N = 0;
  double fastest_m_per_s = 0, hardest_m_per_s2 = 0;

  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kPeriod_s)); ++i) {
      const Vec3 next = hand.next(kPeriod_s, {0, 0, force_N}).position;
      const Vec3 now = (next - position) / kPeriod_s;
      fastest_m_per_s = std::max(fastest_m_per_s, glm::length(now));
      hardest_m_per_s2 = std::max(hardest_m_per_s2, glm::length(now - velocity) / kPeriod_s);
      position = next;
      velocity = now;
      force_N = std::max(0.0, -kGroundAndHand_N_per_m * position.z);
    }
  }
};

std::unique_ptr<ExplorationPlan> planOfOneStroke() {
  Stroke stroke{1, {}, false};
  for (int i = 0; i < 21; ++i) stroke.points.push_back(Vec3(0.002 * i, 0, 0));
  return std::make_unique<ExplorationPlan>(ExplorationPlan{{std::move(stroke)}, 0.1});
}

TEST(LeadableHand, ExploresWhileNobodyLeads) {
  const auto plan = planOfOneStroke();
  LeadableHand hand(nominal(), kMaxForce_N);
  ExploringHand exploring(nominal(), kMaxForce_N);
  hand.follow(plan.get());
  exploring.follow(plan.get());
  for (int tick = 0; tick < 5000; ++tick) {
    const double dt_s = tick == 0 ? 0 : kPeriod_s;
    ASSERT_EQ(hand.next(dt_s, Vec3(0)).position, exploring.next(dt_s, Vec3(0)).position) << tick;
  }
}

// 60 targets a second, 4 ms early or late, every tenth lost, along a circle at 0.2 m/s.
TEST(LeadableHand, FollowsLateEarlyAndLostCommandsSmoothly) {
  Led led;
  std::mt19937 random(7);
  std::uniform_int_distribution<int> gap_ms(12, 21), one(0, 9);
  constexpr double kRadius_m = 0.05, kRate_per_s = 4;
  const auto wanted = [&](double t) {
    return Vec3(kRadius_m * std::cos(kRate_per_s * t), kRadius_m * std::sin(kRate_per_s * t), 0.2);
  };
  led.hand.command(at(wanted(0)));
  led.run(0.3);
  led.fastest_m_per_s = led.hardest_m_per_s2 = 0;
  double t = 0, farthest_m = 0;
  while (t < 20) {
    if (one(random) != 0) led.hand.command(at(wanted(t)));
    const double gap_s = 1e-3 * gap_ms(random);
    led.run(gap_s);
    t += gap_s;
    farthest_m = std::max(farthest_m, glm::distance(led.position, wanted(t)));
  }
  EXPECT_LT(farthest_m, 0.2 * 0.07);    // two intervals and the filter's lag, and once more where one was lost
  EXPECT_LT(led.fastest_m_per_s, 0.4);  // to catch up after a lost one
  EXPECT_LT(led.hardest_m_per_s2, 30);
}

TEST(LeadableHand, NeverGoesFasterThanItsLimitWhateverIsCommanded) {
  Led led;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  std::uniform_int_distribution<int> gap_ms(1, 700);
  for (int i = 0; i < 300; ++i) {
    led.hand.command(pressing({place(random), place(random), place(random)}, std::max(0.0, 20 * place(random))));
    led.run(1e-3 * gap_ms(random));
    if (i % 17 == 0) led.hand.command({});
  }
  EXPECT_LT(led.fastest_m_per_s, LeadableHand::kMaxSpeed_m_per_s + 0.5);  // where the exploring hand moves as well
  EXPECT_LT(led.hardest_m_per_s2, 2 * LeadableHand::kMaxAcceleration_m_per_s2);
}

TEST(LeadableHand, PressesWithTheForceThatIsSet) {
  for (const double press_N : {0.2, 1.0, 2.5}) {
    Led led;
    for (int i = 0; i < 180; ++i) {
      led.hand.command(pressing({0, 0, 0}, press_N));
      led.run(1.0 / 60);
    }
    EXPECT_NEAR(led.force_N, press_N, 0.02 * press_N);
    for (int i = 0; i < 60; ++i) {
      led.hand.command(at({0, 0, 0.02}));
      led.run(1.0 / 60);
    }
    EXPECT_EQ(led.force_N, 0);
    EXPECT_NEAR(led.position.z, 0.02, 1e-6);
  }
}

// The pull of a guide turns as the hand moves, and no retreat ends it: the hand is led all the same.
TEST(LeadableHand, FollowsThoughAFieldPullsItAllTheTime) {
  LeadableHand hand(nominal(), kMaxForce_N);
  Vec3 position = hand.next(0, Vec3(0)).position;
  const Vec3 wanted(0.05, 0.02, 0.1);
  for (int tick = 0; tick < 3000; ++tick) {
    if (tick % 16 == 0) hand.command(at(wanted));
    const Vec3 pull_N(std::cos(0.01 * tick), std::sin(0.01 * tick), 0);
    position = hand.next(kPeriod_s, pull_N).position;
  }
  EXPECT_NEAR(glm::distance(position, wanted), 0, 1e-3);
}

TEST(LeadableHand, PressesWithNoMoreThanTheDeviceResists) {
  Led led;
  for (int i = 0; i < 300; ++i) {
    led.hand.command(pressing({0, 0, 0}, 20));
    led.run(1.0 / 60);
  }
  EXPECT_NEAR(led.force_N, kMaxForce_N / 1.2, 0.01);
}

TEST(LeadableHand, StandsStillWhenItsLeaderIsSilentAndThenLifts) {
  Led led;
  for (int i = 0; i < 60; ++i) {
    led.hand.command(pressing({0.002 * i, 0, 0}, 1));
    led.run(1.0 / 60);
  }
  led.run(0.25);
  const Vec3 held = led.position;
  EXPECT_GT(led.force_N, 0.9);
  led.run(0.2);
  EXPECT_LT(glm::distance(led.position, held), 1e-4);
  led.run(0.25);
  EXPECT_EQ(led.force_N, 0);
  EXPECT_LT(led.hardest_m_per_s2, 2 * LeadableHand::kMaxAcceleration_m_per_s2);
}

TEST(LeadableHand, IsLetGoOfAtOnceWhenItsLeaderGoes) {
  Led led;
  for (int i = 0; i < 60; ++i) {
    led.hand.command(pressing({0.005 * i, 0, 0}, 1));
    led.run(1.0 / 60);
  }
  led.hardest_m_per_s2 = 0;
  led.hand.command({});
  led.run(0.5);
  EXPECT_EQ(led.force_N, 0);
  EXPECT_LT(led.hardest_m_per_s2, 100);
}

TEST(LeadableHand, OpensTheGripperNoFartherThanItGoes) {
  for (const bool hasGripper : {true, false}) {
    const DevicePreset preset = *findDevicePreset(hasGripper ? "sigma.7" : "omega.6");
    LeadableHand hand(*findHandPreset("nominal"), preset.maxForce_N);
    SimulatedDevice device({preset, *findHandPreset("nominal")}, hand);
    std::uint64_t tick = 0;
    const auto opened = [&](std::optional<double> wanted_rad, std::uint64_t ticks) {
      HandleReading handle;
      for (const std::uint64_t end = tick + ticks; tick < end; ++tick) {
        if (tick % 16 == 0) hand.command({.leads = true, .gripper_rad = wanted_rad});
        handle = device.read(tick).handle;
      }
      EXPECT_EQ(handle.has(HandleReading::kGripper), hasGripper);
      return handle.gripper_rad;
    };
    const double open = hasGripper ? 1 : 0;
    EXPECT_EQ(opened(std::nullopt, 1600), 0);
    EXPECT_NEAR(opened(0.3, 80), 0.16 * open, 0.005);
    EXPECT_EQ(opened(0.3, 240), 0.3 * open);
    EXPECT_EQ(opened(3, 480), preset.gripper.range_rad);
    EXPECT_EQ(opened(std::nullopt, 160), preset.gripper.range_rad);
    EXPECT_EQ(opened(0, 480), 0);
  }
}

TEST(LeadableHand, GivesWayToAMomentOnTheGripperAsFarAsItsFingersAreStiff) {
  const DevicePreset preset = *findDevicePreset("sigma.7");
  const HandPreset nominal = *findHandPreset("nominal");
  LeadableHand hand(nominal, preset.maxForce_N);
  SimulatedDevice device({preset, nominal}, hand);
  std::uint64_t tick = 0;
  const auto opened = [&](double moment_Nm) {
    DeviceReading reading;
    for (int i = 0; i < 320; ++i) {
      if (tick % 16 == 0) hand.command({.leads = true, .gripper_rad = 0.2});
      reading = device.read(tick++);
      device.writeGrip(moment_Nm);
      device.write(Vec3(0));
    }
    EXPECT_EQ(reading.gripper_rad, reading.handle.gripper_rad);
    return reading.gripper_rad;
  };
  const double finger_Nm_per_rad = nominal.stiffness_N_per_m * kUsualGyration_m * kUsualGyration_m;
  EXPECT_EQ(opened(0), 0.2);
  EXPECT_NEAR(opened(0.1), 0.2 + 0.1 / finger_Nm_per_rad, 1e-6);
  EXPECT_NEAR(opened(-0.1), 0.2 - 0.1 / finger_Nm_per_rad, 1e-6);
  EXPECT_EQ(opened(1e9), preset.gripper.range_rad) << "no more than its limit, 0.4 Nm, which opens it all";
  EXPECT_NEAR(opened(std::nan("")), 0.2, 1e-6) << "what is no number is none";
  device.stop();
  EXPECT_NEAR(opened(0.1), 0.2, 1e-6);
}

}  // namespace
}  // namespace haptics::leadable_hand_test
