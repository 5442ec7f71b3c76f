#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "common/mesh/generators.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/cache_warmer.h"
#include "haptic_server/servo/server_step_config.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::stabilised_step_tests {
namespace {

using namespace fixture;

constexpr double kRate_Hz = 1000;

/// A box of 100 mm whose upper side is the plane z = 0.
ServoObject slab(double stiffness_N_per_m) {
  ServoObject object = objectOf(1, surfaceOf(makeBox(Vec3(0.1), 4).value()), Vec3(0, 0, -0.05), stiffness_N_per_m);
  object.damping_Ns_per_m = 0;
  return object;
}

/// Lets go of the device a little above the slab, with a constant push.
class DroppingHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {{0.01, 0.012, 1e-3}, {0, 0, -1}}; }
};

DevicePreset desktop() { return findDevicePreset("desktop").value(); }

StepConfig configOf(const SimulatedDevice& device) { return serverStepConfig(device.info(), kRate_Hz); }

/// Peak to peak of the height in the last 0.3 s of 2 s, m.
double cycleOn(double stiffness_N_per_m, SimulatedDevice& device, const StepConfig& config) {
  HapticState state(config);
  const auto scene = sceneOf(1, {slab(stiffness_N_per_m)});
  EXPECT_TRUE(adoptScene(*scene, state, 0));
  double least = 1, most = -1;
  for (std::uint64_t tick = 0; tick < 2000; ++tick) {
    device.write(hapticStep(*scene, state, config, {tick, 0, device.read(tick)}).force.written);
    if (tick < 1700) continue;
    least = std::min(least, device.plant().position().z);
    most = std::max(most, device.plant().position().z);
  }
  return most - least;
}

double cycleOn(double stiffness_N_per_m, bool stabilised, double delay_s) {
  DroppingHand hand;
  SimulatedDevice device({desktop(), findHandPreset("none").value(), 1 / kRate_Hz, delay_s}, hand);
  StepConfig config = configOf(device);
  if (!stabilised) config.observer.reset();
  return cycleOn(stiffness_N_per_m, device, config);
}

TEST(StabilisedStep, RestsOnAWallTenTimesAsStiffAsTheDevicesMakerAllowsAndTheBareStepDoesNot) {
  const double stiffness = 10 * desktop().maxStiffness_N_per_m;
  const double allowed_m = std::max(2 * desktop().resolution_m, 20e-6);
  for (const double delay_s : {0.0, 1e-3}) {
    EXPECT_LE(cycleOn(stiffness, true, delay_s), allowed_m) << delay_s;
    EXPECT_GT(cycleOn(stiffness, false, delay_s), 10 * allowed_m) << delay_s;
  }
}

/// The observer has to follow as fast as the touched stiffness asks for: on the maker's a slow one is enough.
TEST(StabilisedStep, RestsOnThreeTimesTheMakersStiffnessThoughMassFrictionAndDelayAreNotAsTold) {
  DroppingHand hand;
  for (const double mass : {0.5, 2.0}) {
    for (const double makers : {1.0, 1.5, 2.0, 2.5, 3.0}) {
      DevicePreset real = desktop();
      real.apparentMass_kg *= mass;
      real.viscousFriction_Ns_per_m /= 3;
      real.coulombFriction_N /= 3;
      SimulatedDevice device({real, findHandPreset("none").value(), 1 / kRate_Hz, 1e-3}, hand);
      SimulatedDevice told({desktop(), findHandPreset("none").value(), 1 / kRate_Hz, 0}, hand);
      StepConfig config = configOf(told);
      config.rise_s = 0;  // while it rises, the device would sink so deep that it bounces for seconds
      EXPECT_LE(cycleOn(makers * desktop().maxStiffness_N_per_m, device, config), 2 * desktop().resolution_m)
          << mass << " of the mass, " << makers << " of the maker's stiffness";
    }
  }
}

/// Down at 50 mm/s from 5 mm above the slab to 2 mm inside, then along it.
Vec3 pressAndStroke(std::uint64_t tick) {
  const double t = static_cast<double>(tick);
  return {0.01 + 2e-5 * t, 0.012, std::max(0.005 - 5e-5 * t, -0.002)};
}

StepConfig stabilised() {
  StepConfig config;
  config.observer = ObserverSettings{.mass_kg = 0.05, .delay_s = 1e-3};
  return config;
}

TEST(StabilisedStep, TellsTheMeasuredHipBesideTheForeseenOneAtWhichItFeels) {
  VirtualServo servo(pressAndStroke, stabilised(), sceneOf(1, {slab(800)}));
  bool touched = false;
  for (int i = 0; i < 300; ++i) {
    const TelemetrySample sample = servo.step();
    EXPECT_EQ(sample.hip, pressAndStroke(sample.tick));
    if (sample.object == 0) {
      EXPECT_EQ(sample.ihip, sample.hip);
      continue;
    }
    touched = true;
    EXPECT_NEAR(sample.penetration_m, glm::distance(sample.ihip, sample.predictedHip), 1e-12);
    EXPECT_NEAR(sample.force.spring.z, 800 * sample.penetration_m, 1e-9);
  }
  EXPECT_TRUE(touched);
  VirtualServo bare(pressAndStroke, StepConfig{}, sceneOf(1, {slab(800)}));
  for (int i = 0; i < 300; ++i) {
    const TelemetrySample sample = bare.step();
    EXPECT_EQ(sample.predictedHip, sample.hip);
  }
}

TEST(StabilisedStep, GivesHookesLawOnAHeldSurface) {
  VirtualServo servo([](std::uint64_t tick) { return pressAndStroke(std::min<std::uint64_t>(tick, 200)); },
                     stabilised(), sceneOf(1, {slab(800)}));
  // What the observer cannot explain, it takes for the hand's force: at rest nothing of it is left.
  EXPECT_NEAR(servo.run(1000).force.written.z, 800 * 0.002, 1e-6);
}

TEST(StabilisedStep, GoesOnBitForBitFromACopyOfItsStateAndFromARehearsal) {
  const StepConfig config = stabilised();
  const auto scene = sceneOf(1, {slab(800)});
  HapticState plain(config), rehearsed(config);
  (void)adoptScene(*scene, plain, 0);
  (void)adoptScene(*scene, rehearsed, 0);
  const auto cacheWarmer = std::make_unique<CacheWarmer>(config);
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    (*cacheWarmer)(*scene, rehearsed);
    const StepInput input{tick, 0, {pressAndStroke(tick % 400), DeviceState::kReady}};
    const Vec3 a = hapticStep(*scene, plain, config, input).force.written;
    const Vec3 b = hapticStep(*scene, rehearsed, config, input).force.written;
    ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0) << tick;
  }
}

}  // namespace
}  // namespace haptics::stabilised_step_tests
