#include "haptic_server/device/simulated_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace haptics::simulated_device_test {
namespace {

/// A hand that stays where it is, pushes, and remembers what it was told.
struct StillHand final : HandIntent {
  HandTarget target;
  std::vector<Vec3> felt;
  const ExplorationPlan* plan = nullptr;

  HandTarget next(double, Vec3 felt_N) noexcept override {
    felt.push_back(felt_N);
    return target;
  }
  void follow(const ExplorationPlan* newPlan) noexcept override { plan = newPlan; }
};

constexpr DevicePreset kFrictionless{"test", "Test", 5, 1000, 5, 0.1, 0, 0, 1e-9};
constexpr HandPreset kNoHand{"none", 0, 0, 0};

DevicePreset omni() { return findDevicePreset("omni").value(); }
HandPreset nominal() { return findHandPreset("nominal").value(); }

TEST(SimulatedDevice, DescribesItsPreset) {
  StillHand hand;
  const SimulatedDevice device({omni(), nominal()}, hand);
  EXPECT_EQ(device.info().name, "Phantom Omni (simulated)");
  EXPECT_EQ(device.info().maxForce_N, 3.3);
  EXPECT_EQ(device.info().maxStiffness_N_per_m, 700);
  EXPECT_EQ(device.info().maxDamping_Ns_per_m, 5);
  EXPECT_EQ(device.info().resolution_m, 55e-6);
}

TEST(SimulatedDevice, BeginsWhereTheHandBegins) {
  StillHand hand;
  hand.target.position = {0.01, 0.02, 0.03};
  SimulatedDevice device({kFrictionless, kNoHand}, hand);
  const DeviceReading reading = device.read(123456);
  EXPECT_LT(glm::distance(reading.position, hand.target.position), 1e-8);
  EXPECT_EQ(reading.state, DeviceState::kReady);
}

TEST(SimulatedDevice, SeveralAdvanceTogetherAsEachDoesByItself) {
  constexpr std::uint64_t kTicks = 500;
  const auto run = [](bool together) {
    StillHand still, pushing;
    pushing.target.push_N = {0.1, -0.5, 0.4};
    SimulatedDevice devices[] = {{{omni(), kNoHand}, pushing},
                                 {{omni(), nominal(), 1e-3, 1.5e-3}, still},
                                 {{kFrictionless, nominal(), 1e-3, 1e-3}, pushing}};
    SimulatedDevice* const all[] = {&devices[0], &devices[1], &devices[2]};
    std::vector<Vec3> places;
    for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
      if (together) SimulatedDevice::advanceTogether(all, tick);
      for (SimulatedDevice* device : all) {
        const Vec3 measured = device->read(tick).position;
        places.push_back(measured);
        places.push_back(device->plant().position());
        device->write(-200.0 * measured + Vec3(0.3 * std::sin(0.02 * static_cast<double>(tick)), 0, 0));
      }
    }
    return places;
  };
  const std::vector<Vec3> places = run(true);
  EXPECT_EQ(places, run(false));
  EXPECT_NE(places.back(), Vec3(0));
}

TEST(SimulatedDevice, ReadsPositionsInWholeQuanta) {
  StillHand hand;
  hand.target.push_N = {0.4, -0.3, 0.2};
  SimulatedDevice device({omni(), kNoHand}, hand);
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    const Vec3 position = device.read(tick).position;
    for (int axis = 0; axis < 3; ++axis) {
      const double quanta = position[axis] / device.info().resolution_m;
      EXPECT_NEAR(quanta, std::round(quanta), 1e-9);
      EXPECT_LE(std::abs(position[axis] - device.plant().position()[axis]), 0.500001 * device.info().resolution_m);
    }
  }
  EXPECT_GT(glm::length(device.plant().position()), 0.01);
}

TEST(SimulatedDevice, HoldsAForceUntilTheNextOne) {
  StillHand hand;
  SimulatedDevice device({kFrictionless, kNoHand}, hand);
  static_cast<void>(device.read(0));
  device.write({1, 0, 0});
  for (std::uint64_t tick = 1; tick <= 100; ++tick) static_cast<void>(device.read(tick));
  EXPECT_NEAR(device.plant().position().x, 0.5 * 1 / 0.1 * 0.1 * 0.1, 1e-12);
}

TEST(SimulatedDevice, ShortensAForceBeyondItsLimitWithoutTurningIt) {
  StillHand hand;
  SimulatedDevice strong({kFrictionless, kNoHand}, hand), limited({kFrictionless, kNoHand}, hand);
  const Vec3 direction = glm::normalize(Vec3(1, 2, -3));
  for (std::uint64_t tick = 0; tick < 50; ++tick) {
    static_cast<void>(strong.read(tick));
    static_cast<void>(limited.read(tick));
    limited.write(kFrictionless.maxForce_N * direction);
    strong.write(1e6 * direction);
  }
  EXPECT_GT(glm::length(strong.plant().position()), 0.01);
  EXPECT_LT(glm::distance(strong.plant().position(), limited.plant().position()), 1e-12);
}

TEST(SimulatedDevice, TakesAForceThatIsNotFiniteAsZero) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const double largest = std::numeric_limits<double>::max();
  for (const Vec3 bad : {Vec3(nan, 1, 1), Vec3(1, infinity, 1), Vec3(1, 1, -infinity), Vec3(largest)}) {
    StillHand hand;
    SimulatedDevice device({kFrictionless, kNoHand}, hand);
    static_cast<void>(device.read(0));
    device.write({1, 0, 0});
    device.write(bad);
    const Vec3 position = device.read(10).position;
    EXPECT_TRUE(isFinite(position));
    EXPECT_EQ(device.plant().velocity(), Vec3(0));
  }
}

TEST(SimulatedDevice, GivesNoForceAfterStop) {
  StillHand hand;
  SimulatedDevice device({kFrictionless, kNoHand}, hand);
  static_cast<void>(device.read(0));
  device.write({1, 0, 0});
  device.stop();
  device.write({1, 0, 0});
  EXPECT_EQ(device.read(20).state, DeviceState::kStopped);
  EXPECT_EQ(device.plant().velocity(), Vec3(0));
}

TEST(SimulatedDevice, DelayedByWholeTicksItDoesTheSameLater) {
  constexpr std::uint64_t kDelay = 3;
  StillHand hand;
  SimulatedDevice prompt({kFrictionless, kNoHand, 1e-3, 0}, hand), late({kFrictionless, kNoHand, 1e-3, 3e-3}, hand);
  std::vector<Vec3> positions;
  for (std::uint64_t tick = 0; tick < 200; ++tick) {
    positions.push_back(prompt.read(tick).position);
    const Vec3 force(std::sin(0.1 * static_cast<double>(tick)), 1, 0);
    prompt.write(force);
    const Vec3 position = late.read(tick).position;
    EXPECT_EQ(position, tick < kDelay ? Vec3(0) : positions[tick - kDelay]) << tick;
    late.write(force);
  }
}

TEST(SimulatedDevice, ADelayMayBeAFractionOfATick) {
  for (const double delay : {0.0, 0.25e-3, 0.6e-3, 1e-3, 2.35e-3}) {
    StillHand hand;
    SimulatedDevice device({kFrictionless, kNoHand, 1e-3, delay}, hand);
    static_cast<void>(device.read(0));
    device.write({1, 0, 0});
    static_cast<void>(device.read(10));
    const double moving = 10e-3 - delay;
    EXPECT_NEAR(device.plant().position().x, 1 / 0.1 * moving * moving / 2, 1e-12) << delay;
  }
}

TEST(SimulatedDevice, TheHandFeelsWhatTheMotorsGiveLate) {
  StillHand hand;
  SimulatedDevice device({omni(), nominal(), 1e-3, 2e-3}, hand);
  static_cast<void>(device.read(0));
  device.write({0, 0, 1});
  for (std::uint64_t tick = 1; tick <= 6; ++tick) static_cast<void>(device.read(tick));
  const std::vector<Vec3> expected{Vec3(0), Vec3(0), Vec3(0), Vec3(0), {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  EXPECT_EQ(hand.felt, expected);
}

TEST(SimulatedDevice, IntegratesSkippedTicksAsIfTheyHadBeenRead) {
  StillHand hand;
  hand.target.position = {0.001, 0, 0.002};
  SimulatedDevice each({omni(), nominal()}, hand), some({omni(), nominal()}, hand);
  std::uint64_t tick = 0;
  for (const std::uint64_t gap : {1, 7, 1, 20, 2, 100}) {
    const Vec3 force(0.5, 0.01 * static_cast<double>(gap), -1);
    static_cast<void>(each.read(tick));
    static_cast<void>(some.read(tick));
    each.write(force);
    some.write(force);
    for (std::uint64_t i = 1; i <= gap; ++i) static_cast<void>(each.read(tick + i));
    tick += gap;
    EXPECT_EQ(some.read(tick).position, each.read(tick).position);
    EXPECT_EQ(some.plant().velocity(), each.plant().velocity());
  }
}

TEST(SimulatedDevice, LosesTheTimeOfAGapThatIsTooLong) {
  StillHand hand;
  SimulatedDevice stopped({kFrictionless, kNoHand}, hand), steady({kFrictionless, kNoHand}, hand);
  for (SimulatedDevice* device : {&stopped, &steady}) {
    static_cast<void>(device->read(0));
    device->write({1, 0, 0});
  }
  EXPECT_EQ(stopped.read(std::uint64_t{1} << 62).position, steady.read(SimulatedDevice::kMaxTicksAtOnce).position);
  EXPECT_EQ(stopped.read((std::uint64_t{1} << 62) + 1).position,
            steady.read(SimulatedDevice::kMaxTicksAtOnce + 1).position);
}

TEST(SimulatedDevice, DoesNotMoveBetweenReadsOfOneTick) {
  StillHand hand;
  hand.target.push_N = {1, 0, 0};
  SimulatedDevice device({kFrictionless, kNoHand}, hand);
  static_cast<void>(device.read(0));
  const Vec3 position = device.read(5).position;
  EXPECT_EQ(device.read(5).position, position);
  EXPECT_EQ(device.read(4).position, position);
}

TEST(SimulatedDevice, PassesThePlanToTheHand) {
  StillHand hand;
  SimulatedDevice device({omni(), nominal()}, hand);
  const ExplorationPlan* const plan = reinterpret_cast<const ExplorationPlan*>(&hand);  // only its address matters
  device.follow(plan);
  EXPECT_EQ(hand.plan, plan);
}

TEST(SimulatedDevice, RepeatsItselfBitForBit) {
  const auto positions = [] {
    std::mt19937_64 engine(11);
    std::uniform_real_distribution<double> force(-3, 3);
    StillHand hand;
    SimulatedDevice device({omni(), nominal(), 1e-3, 0.7e-3}, hand);
    std::vector<Vec3> all;
    for (std::uint64_t tick = 0; tick < 2000; ++tick) {
      all.push_back(device.read(tick).position);
      device.write({force(engine), force(engine), force(engine)});
    }
    return all;
  };
  EXPECT_EQ(positions(), positions());
}

}  // namespace
}  // namespace haptics::simulated_device_test
