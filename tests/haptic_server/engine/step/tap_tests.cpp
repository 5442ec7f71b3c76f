// Taps: their law, the device that rings by them, their bounds, edits, copies.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/recording/state_image.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::tap_tests {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr double kBudget_J = 5e-3, kMost_N = 2;

struct Sound {
  std::string name;
  double perSpeed_Ns_per_m = 0, frequency_Hz = 0, decay_per_s = 0;
};
const std::array kSounds{Sound{"rubber", 5.8, 18, 60}, Sound{"wood", 7.5, 30, 80}, Sound{"metal", 15, 100, 90}};

ServoObject sounding(ServoObject object, const Sound& sound) {
  SurfaceProperties properties;
  properties.scalars.tap_Ns_per_m = sound.perSpeed_Ns_per_m;
  properties.scalars.tap_Hz = sound.frequency_Hz;
  properties.scalars.tap_decay_per_s = sound.decay_per_s;
  return with(std::move(object), properties);
}

/// Down to the slab and 3 mm into it at a speed.
VirtualServo::Trajectory down(double speed_m_per_s) {
  return [=](std::uint64_t tick) {
    return Vec3(0.003, 0.0123, std::max(-0.003, 0.0101 - 1e-3 * speed_m_per_s * static_cast<double>(tick)));
  };
}

TEST(Tap, RingsAsItsModelAndIsOverAfterATenthOfASecond) {
  for (const Sound& sound : kSounds) {
    for (const double speed : {0.02, 0.1}) {
      VirtualServo servo(down(speed), kConfig, sceneOf(1, {sounding(slab(), sound)}));
      VirtualServo without(down(speed), kConfig, sceneOf(1, {slab()}));
      int since = -1;
      double met_m_per_s = 0;
      for (int tick = 0; tick < 800; ++tick) {
        const TelemetrySample sample = servo.step();
        const Vec3 bare_N = without.step().force.written;
        if (since >= 0 || sample.object != 0) ++since;
        if (since == 0) met_m_per_s = -servo.state().estimate.velocity.velocity().z;
        const double t = kPeriod_s * std::max(since, 0);
        const double envelope_N = sound.perSpeed_Ns_per_m * met_m_per_s * std::exp(-sound.decay_per_s * t);
        const double model_N = envelope_N * std::sin(2 * std::numbers::pi * sound.frequency_Hz * t);
        const Vec3 tap_N = sample.force.written - bare_N;
        if (envelope_N > 5e-3 + 1e-9) {
          ASSERT_LE(glm::distance(tap_N, Vec3(0, 0, model_N)), 1e-9) << sound.name << " tick " << tick;
        } else {
          ASSERT_EQ(tap_N, Vec3(0)) << sound.name << " tick " << tick;
        }
        ASSERT_TRUE(t <= 0.1 || envelope_N < 5e-3) << sound.name;
      }
      EXPECT_NEAR(met_m_per_s, speed, 0.02 * speed);
      EXPECT_GT(since, 200);
    }
  }
}

struct Pressing final : HandIntent {
  HandTarget next(double, Vec3) noexcept override { return {Vec3(0.003, 0.0123, 0.00025), Vec3(0, 0, -0.8)}; }
};

constexpr std::size_t kRinging = 50;  // ticks in which each is above the 5 mN with which it ends

/// How a device is accelerated that a hand lets fall a quarter of a millimetre onto the slab and presses on it; after it has met it.
/// @param pushed  What it is pushed with besides, from there on, as by a tap.
std::vector<double> accelerations(const DevicePreset& preset, const HandPreset& hand, const ServoObject& object,
                                  const Sound& pushed) {
  Pressing pressing;
  SimulatedDevice device({preset, hand, kPeriod_s}, pressing);
  VirtualServo servo({}, {.period_s = kPeriod_s, .maxForce_N = preset.maxForce_N}, sceneOf(1, {object}));
  std::vector<double> all;
  double met_m_per_s = 0;
  for (std::uint64_t tick = 0; all.size() < kRinging && tick < 2000; ++tick) {
    const double before = device.plant().velocity().z;
    const Vec3 at = device.read(tick).position;
    const double now = device.plant().velocity().z;
    const TelemetrySample sample = servo.stepAt(at, DeviceState::kReady);
    if (met_m_per_s > 0) all.push_back((now - before) / kPeriod_s);
    if (met_m_per_s == 0 && sample.object != 0) met_m_per_s = -servo.state().estimate.velocity.velocity().z;
    const double t = kPeriod_s * static_cast<double>(all.size());
    const double push_N = pushed.perSpeed_Ns_per_m * met_m_per_s * std::exp(-pushed.decay_per_s * t) *
                          std::sin(2 * std::numbers::pi * pushed.frequency_Hz * t);
    device.write(sample.force.written + Vec3(0, 0, push_N));
  }
  return all;
}

/// A device with its friction and its encoder's steps is not linear, so what a tap adds to its acceleration is no sum of sinusoids. Of
/// all that decay, the one is looked for by which the device has to be pushed on a silent slab to be accelerated as it is by the tap.
TEST(Tap, EveryDeviceRingsAtItsFrequencyAndDecay) {
  const Sound silent{};
  double worst = 0;
  for (const DevicePreset& preset : devicePresets()) {
    for (const char* name : {"light", "nominal"}) {
      const HandPreset hand = findHandPreset(name).value();
      ServoObject wall = slab();
      wall.stiffness_N_per_m = 300;
      wall.damping_Ns_per_m = 0;
      for (const Sound& sound : kSounds) {
        const std::vector<double> rings = accelerations(preset, hand, sounding(wall, sound), silent);
        ASSERT_EQ(rings.size(), kRinging) << preset.name << ' ' << name << ' ' << sound.name;
        const auto misfit = [&](const Sound& pushed) {
          double square = 0;
          const std::vector<double> is = accelerations(preset, hand, wall, pushed);
          for (std::size_t i = 0; i < kRinging; ++i) square += std::pow(is[i] - rings[i], 2);
          return square;
        };
        Sound nearest = sound;
        nearest.frequency_Hz *= 1.25;
        nearest.decay_per_s *= 0.7;
        double least = misfit(nearest);
        for (double step = 0.2; step > 0.002;) {
          const Sound last = nearest;
          for (double Sound::*number : {&Sound::frequency_Hz, &Sound::decay_per_s}) {
            for (const double factor : {1 + step, 1 / (1 + step)}) {
              Sound tried = nearest;
              tried.*number *= factor;
              const double its = misfit(tried);
              if (its < least) least = its, nearest = tried;
            }
          }
          if (nearest.frequency_Hz == last.frequency_Hz && nearest.decay_per_s == last.decay_per_s) step /= 2;
        }
        const double off = std::max(std::abs(nearest.frequency_Hz / sound.frequency_Hz - 1),
                                    std::abs(nearest.decay_per_s / sound.decay_per_s - 1));
        EXPECT_LE(off, 0.1) << preset.name << ' ' << name << ' ' << sound.name << ": " << nearest.frequency_Hz
                            << " Hz, " << nearest.decay_per_s << " per s";
        worst = std::max(worst, off);
      }
    }
  }
  RecordProperty("worst_percent", std::to_string(100 * worst));
}

/// A hand that goes with the tap as long as it rings, and then down for the next one.
TEST(Tap, GivesNoMoreForceThanADeviceBearsAndNoMoreEnergyThanItsBudget) {
  for (const double maxForce_N : {3.0, 12.0}) {
    const Sound loud{"loud", 100, 25, 60};
    VirtualServo servo({}, {.period_s = kPeriod_s, .maxForce_N = maxForce_N}, sceneOf(1, {sounding(slab(), loud)}));
    Vec3 hand(0.003, 0.0123, 0.002), last_N(0);
    double given_J = 0, strongest_N = 0, step_N = 0;
    for (int tick = 0; tick < 10'000; ++tick) {
      const double way_m = last_N.z != 0 ? std::copysign(5e-4, last_N.z) : -5e-4;
      const double to = std::clamp(hand.z + way_m, -0.01, 0.01);
      given_J += last_N.z * (to - hand.z);
      hand.z = to;
      static_cast<void>(servo.stepAt(hand, DeviceState::kReady));
      const Vec3 now_N = servo.state().surface.tap.force_N;
      strongest_N = std::max(strongest_N, glm::length(now_N));
      step_N = std::max(step_N, glm::distance(now_N, last_N));
      last_N = now_N;
      ASSERT_LE(given_J, kBudget_J * (1 + kPeriod_s * tick) + 5e-4 * kMost_N) << "tick " << tick;
    }
    const double most_N = std::min(kMost_N, maxForce_N / 2);
    EXPECT_LE(strongest_N, most_N);
    EXPECT_GT(strongest_N, 0.5 * most_N);
    EXPECT_GT(given_J, 4 * kBudget_J) << "the hand took what it could";
    const double turned = 2 * std::numbers::pi * loud.frequency_Hz * kPeriod_s, spent = 2 * 5e-4 * most_N / kBudget_J;
    EXPECT_LE(step_N, most_N * (turned + spent)) << "no step where it is touched again, or the budget ends";
  }
}

/// No chatter, and at rest in the end, with every device that nobody holds, or a light hand.
TEST(Tap, ComesToRestOnASafeWall) {
  struct Leaning final : HandIntent {
    HandTarget next(double, Vec3) noexcept override { return {Vec3(0.003, 0.0123, 0.002), Vec3(0, 0, -1)}; }
  };
  for (const DevicePreset& preset : devicePresets()) {
    for (const char* name : {"none", "light"}) {
      for (const Sound& sound : kSounds) {
        Leaning leaning;
        SimulatedDevice device({preset, findHandPreset(name).value(), kPeriod_s}, leaning);
        ServoObject wall = slab();
        wall.stiffness_N_per_m = 300;  // as ClosedLoop.RestsOnASafeWallWithEveryDeviceAndHand
        VirtualServo servo({}, {.period_s = kPeriod_s, .maxForce_N = preset.maxForce_N},
                           sceneOf(1, {sounding(wall, sound)}));
        double least = 1, most = -1;
        for (std::uint64_t tick = 0; tick < 6000; ++tick) {
          const Vec3 at = device.read(tick).position;
          device.write(servo.stepAt(at, DeviceState::kReady).force.written);
          if (tick < 5000) continue;
          least = std::min(least, at.z);
          most = std::max(most, at.z);
        }
        EXPECT_LE(most - least, std::max(2 * preset.resolution_m, 20e-6) * 1.001)
            << preset.name << ' ' << name << ' ' << sound.name;
      }
    }
  }
}

TEST(Tap, GoesOnOverTheEditThatTakesItAway) {
  VirtualServo servo(down(0.1), kConfig, sceneOf(1, {sounding(slab(), kSounds[2])}));
  while (servo.step().object == 0) continue;
  servo.run(3);
  VirtualServo edited = servo;
  edited.adopt(sceneOf(2, {slab()}));
  ASSERT_TRUE(edited.adopted());
  for (int i = 0; i < 90; ++i) {
    const double apart_N = glm::distance(servo.step().force.written, edited.step().force.written);
    ASSERT_EQ(servo.state().surface.tap.force_N, edited.state().surface.tap.force_N) << "tick " << i;
    ASSERT_LE(apart_N, std::max(0.0, 1 - 0.03 * i) + 1e-9)
        << "what changed in the tick of the edit is let in, tick " << i;
  }
  EXPECT_TRUE(edited.state().features.taps);
  edited.run(100);
  edited.adopt(sceneOf(3, {slab()}));
  EXPECT_FALSE(edited.state().features.taps);
  EXPECT_FALSE(edited.state().features.extras) << "a scene without taps takes none of their path";
}

TEST(Tap, ACopyAndAnImageGoOnAlike) {
  const auto hammer = [](std::uint64_t tick) {
    return Vec3(0.003, 0.0123, 0.002 * std::sin(0.08 * static_cast<double>(tick)));
  };
  VirtualServo servo(hammer, kConfig, sceneOf(1, {sounding(slab(), kSounds[1])}));
  servo.run(333);
  ASSERT_TRUE(servo.state().surface.tap.rings());
  VirtualServo copy = servo;
  for (int i = 0; i < 500; ++i) ASSERT_EQ(servo.step().force.written, copy.step().force.written);
  EXPECT_EQ(stateImage(servo.state()), stateImage(copy.state()));
}

TEST(Tap, ItsEnergyIsCountedForWhatWasTouched) {
  ServoObject object = sounding(slab(), kSounds[0]);
  object.id = 7;
  // Off the surface at once, so that nothing but the tap acts.
  const auto hand = [](std::uint64_t tick) {
    return Vec3(0.003, 0.0123,
                tick < 101 ? 0.01 - 1e-4 * static_cast<double>(tick) : 1e-4 * static_cast<double>(tick - 99));
  };
  VirtualServo servo(hand, kConfig, sceneOf(1, {object}));
  double tap_J = 0;
  Vec3 last_N(0);
  for (std::uint64_t tick = 0; tick < 220; ++tick) {
    tap_J += last_N.z * (tick > 0 ? hand(tick).z - hand(tick - 1).z : 0);
    last_N = servo.step().force.written;
  }
  EnergyState energy;
  servo.state().energy.copyTo(energy);
  ASSERT_EQ(energy.objectCount, 1U);
  EXPECT_EQ(energy.object[0].object, 7U);
  EXPECT_GT(std::abs(tap_J), 1e-6);
  EXPECT_NEAR(energy.object[0].given_J[0], tap_J, 1e-9);
}

}  // namespace
}  // namespace haptics::fixture::tap_tests
