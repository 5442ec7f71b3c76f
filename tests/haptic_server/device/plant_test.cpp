#include "haptic_server/device/plant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptics::plant_test {
namespace {

constexpr double kStep = 50e-6;  // s

DevicePreset deviceWith(double mass, double viscous, double coulomb) {
  return {"test", "Test", 10, 1000, 5, mass, viscous, coulomb, 1e-6};
}

constexpr HandPreset kNoHand{"none", 0, 0, 0};

void run(Plant& plant, double seconds, Vec3 motor_N, const HandTarget& target = {}) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) plant.step(kStep, motor_N, target, Vec3(0));
}

class Directions {
 public:
  Vec3 next() { return glm::normalize(Vec3(normal_(engine_), normal_(engine_), normal_(engine_))); }

 private:
  std::mt19937_64 engine_{7};
  std::normal_distribution<double> normal_;
};

TEST(Plant, FollowsTheParabolaOfAConstantForceExactly) {
  Plant plant(deviceWith(0.1, 0, 0), kNoHand);
  const Vec3 force(0.3, -0.2, 0.1);
  run(plant, 0.2, force);
  EXPECT_LT(glm::distance(plant.position(), force / 0.1 * (0.2 * 0.2 / 2)), 1e-12);
  EXPECT_LT(glm::distance(plant.velocity(), force / 0.1 * 0.2), 1e-12);
}

TEST(Plant, ApproachesTheSpeedAtWhichViscousFrictionBalancesTheForce) {
  const double mass = 0.1, viscous = 0.5, force = 1;
  Plant plant(deviceWith(mass, viscous, 0), kNoHand);
  run(plant, 0.3, {force, 0, 0});
  const double expected = force / viscous * (1 - std::exp(-viscous * 0.3 / mass));
  EXPECT_NEAR(plant.velocity().x, expected, 1e-6 * expected);
}

TEST(Plant, SwingsOnTheHandAsADampedOscillatorDoes) {
  const HandPreset hand{"test", 0.05, 300, 1};
  const double mass = 0.1, away = 0.01, seconds = 0.1;
  Plant plant(deviceWith(mass - hand.mass_kg, 0, 0), hand);
  plant.place(Vec3(away, 0, 0));
  run(plant, seconds, Vec3(0));
  const double decay = hand.damping_Ns_per_m / (2 * mass);
  const double omega = std::sqrt(hand.stiffness_N_per_m / mass - decay * decay);
  const double expected =
      away * std::exp(-decay * seconds) * (std::cos(omega * seconds) + decay / omega * std::sin(omega * seconds));
  EXPECT_NEAR(plant.position().x, expected, 1e-7);  // the finest encoder resolves 1e-5
}

TEST(Plant, SticksInEveryDirectionUpToTheCoulombFriction) {
  const double friction = 0.26;
  Directions directions;
  for (int i = 0; i < 100; ++i) {
    Plant plant(deviceWith(0.045, 0.05, friction), kNoHand);
    const Vec3 start(0.01, -0.02, 0.03);
    const Vec3 along = directions.next();
    plant.place(start);
    run(plant, 0.05, 0.999 * friction * along);
    EXPECT_EQ(plant.position(), start);
    EXPECT_EQ(plant.velocity(), Vec3(0));
    run(plant, 0.05, 1.001 * friction * along);
    EXPECT_GT(glm::dot(plant.position() - start, along), 0);
  }
}

TEST(Plant, ComesToRestByFrictionAndStaysThere) {
  const double mass = 0.1, friction = 0.05;
  Plant plant(deviceWith(mass, 0, friction), kNoHand);
  run(plant, 0.1, {0.55, 0, 0});
  const double speed = plant.velocity().x, from = plant.position().x;
  ASSERT_NEAR(speed, 0.5, 1e-9);
  const double untilRest = mass * speed / friction;
  run(plant, 0.9 * untilRest, Vec3(0));
  EXPECT_GT(plant.velocity().x, 0);
  run(plant, 0.2 * untilRest, Vec3(0));
  EXPECT_EQ(plant.velocity(), Vec3(0));
  EXPECT_NEAR(plant.position().x - from, mass * speed * speed / (2 * friction), 1e-5);
  const Vec3 rest = plant.position();
  run(plant, 1, Vec3(0));
  EXPECT_EQ(plant.position(), rest);
}

TEST(Plant, LosesEnergyInEveryStepWhenNobodyMovesTheTarget) {
  Directions directions;
  for (const DevicePreset& device : devicePresets()) {
    for (const HandPreset& hand : handPresets()) {
      Plant plant(device, hand);
      const HandTarget target{0.01 * directions.next(), Vec3(0)};
      plant.place(target.position + 0.02 * directions.next());
      run(plant, 0.01, 2.0 * directions.next(), target);
      const auto energy = [&] {
        return plant.mass_kg() / 2 * squaredLength(plant.velocity()) +
               hand.stiffness_N_per_m / 2 * squaredLength(plant.position() - target.position);
      };
      const double rounding = 1e-13 * energy();
      for (int i = 0; i < 100000; ++i) {
        const double before = energy();
        plant.step(kStep, Vec3(0), target, Vec3(0));
        ASSERT_LE(energy(), before + rounding) << device.name << ' ' << hand.name << ' ' << i;
      }
      EXPECT_LT(glm::length(plant.velocity()), 1e-6) << device.name << ' ' << hand.name;
    }
  }
}

TEST(Plant, MovesBothMassesWhenAHandHoldsIt) {
  const HandPreset limp{"test", 0.3, 0, 0};
  Plant plant(deviceWith(0.1, 0, 0), limp);
  run(plant, 0.1, {0.4, 0, 0});
  EXPECT_NEAR(plant.velocity().x, 0.4 / 0.4 * 0.1, 1e-12);
}

TEST(Plant, FollowsAMovingTargetWithoutLagWhenTheHandIsAllThatActs) {
  Plant plant(deviceWith(0.1, 0, 0), HandPreset{"test", 0.1, 400, 12});
  const Vec3 speed(0.1, 0, 0);
  double time = 0;
  for (int i = 0; i < 40000; ++i, time += kStep)
    plant.step(kStep, Vec3(0), {speed * (time + kStep / 2), Vec3(0)}, speed);
  EXPECT_LT(glm::distance(plant.position(), speed * time), 1e-9);
}

}  // namespace
}  // namespace haptics::plant_test
