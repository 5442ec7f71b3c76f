#include "graphics_client/client/guest_port.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

namespace haptics::guest_port_test {
namespace {

constexpr double kTick_s = 1e-3, kStiffness_N_per_m = 400;
constexpr double kFriction = 0.5, kWeight_N_per_kg = 9.81;

/// An engine of one body that slides along x with friction, in steps of 1 ms; its left side is felt.
class Slider {
 public:
  explicit Slider(double mass_kg) : mass_kg_(mass_kg) {}

  void move(GuestPort& port) {
    const GuestPort::Wrench& wrench = port.wrench();
    const double before_m = x_m, still_N = kFriction * kWeight_N_per_kg * mass_kg_;
    const double pushed = speed + kTick_s * wrench.force_N[0] / mass_kg_;
    const double left = std::max(0.0, std::abs(pushed) - kTick_s * still_N / mass_kg_);
    speed = std::copysign(left, pushed) / (1 + kTick_s * wrench.damping_Ns_per_m / mass_kg_);
    x_m += kTick_s * speed;
    port.moved({x_m - before_m, 0, 0}, {}, {}, kTick_s);
  }

  double x_m = 0, speed = 0;

 private:
  double mass_kg_;
};

/// The device in a light hand, 0.05 kg each, held by a spring to where the hand means to be.
struct LightHand {
  double x_m, speed = 0;

  void move(double force_N, double to_m) {
    for (int i = 0; i < 10; ++i) {
      speed += kTick_s / 10 * (force_N + 100 * (to_m - x_m) - 0.7 * speed) / 0.1;
      x_m += kTick_s / 10 * speed;
    }
  }
};

struct Felt {
  double least_J = 0, largest_N = 0, last_N = 0, shakes_N = 0, pushed_m = 0, speed = 0;
};

/// The hand comes at 20 mm/s for `seconds`, and stays there for as long; then it goes back, or stays. Four times `seconds` in all.
/// @param sleeps  Ticks in a row that the servo misses in every tenth of a second on the hand's way in.
Felt push(double rate_Hz, double late_s, double mass_kg, double seconds, bool leaves, int sleeps = 0) {
  GuestPort port({.body = 1, .stiffness_N_per_m = kStiffness_N_per_m, .exchange_s = 1 / rate_Hz, .late_s = late_s});
  Slider body(mass_kg);
  LightHand hand{-0.02};
  struct Pose {
    double due_s, x_m;
  };
  struct Due {
    double due_s;
    Client::Tick tick;
  };
  std::deque<Pose> poses;
  std::deque<Due> ticks;
  double surface_m = 0, to_m = 0, force_N = 0;
  int left = 0;
  const int between = static_cast<int>(1 / rate_Hz / kTick_s + 0.5);
  Felt felt;
  for (int n = 0; n < static_cast<int>(4 * seconds / kTick_s); ++n) {
    const double t = n * kTick_s;
    for (; !poses.empty() && poses.front().due_s <= t; poses.pop_front(), left = between) to_m = poses.front().x_m;
    const double before_N = force_N;
    if (n % 100 >= sleeps || t > seconds) {
      if (left > 0) surface_m += (to_m - surface_m) / left--;
      force_N = std::max(0.0, kStiffness_N_per_m * (hand.x_m - surface_m));
      ticks.push_back({t + late_s / 2,
                       {.hip_m = {hand.x_m, 0, 0},
                        .ihip_m = {surface_m, 0, 0},
                        .force_N = {-force_N, 0, 0},
                        .touched = force_N > 0 ? std::uint64_t{1} : std::uint64_t{0},
                        .missed = static_cast<std::uint64_t>(n % 100 == sleeps ? sleeps : 0)}});
    }
    const double reach_m = -0.02 + 0.02 * seconds;
    hand.move(-force_N, t < seconds                  ? -0.02 + 0.02 * t
                        : !leaves || t < 2 * seconds ? reach_m
                                                     : reach_m - 0.05 * (t - 2 * seconds));
    felt.largest_N = std::max(felt.largest_N, force_N);
    if (t > 3 * seconds) felt.shakes_N = std::max(felt.shakes_N, std::abs(force_N - before_N));
    if (n % between != between - 1) continue;
    for (; !ticks.empty() && ticks.front().due_s <= t; ticks.pop_front()) port.add(ticks.front().tick);
    port.exchange();
    for (int i = 0; i < between; ++i) body.move(port);
    poses.push_back({t + late_s / 2 + kTick_s, body.x_m});
  }
  felt.least_J = port.lowest_J();
  felt.last_N = force_N;
  felt.pushed_m = body.x_m;
  felt.speed = std::abs(body.speed);
  return felt;
}

class GuestPortTest : public testing::TestWithParam<std::tuple<double, double, double>> {};

INSTANTIATE_TEST_SUITE_P(RatesDelaysMasses, GuestPortTest,
                         testing::Combine(testing::Values(50.0, 100.0, 500.0), testing::Values(0.0, 0.02),
                                          testing::Values(0.01, 0.1, 1.0, 10.0)));

TEST_P(GuestPortTest, MakesNoEnergyAndRestsInTheHand) {
  const auto [rate_Hz, late_s, mass_kg] = GetParam();
  const Felt rests = push(rate_Hz, late_s, mass_kg, 3, false);
  EXPECT_GE(rests.least_J, -1e-6);
  EXPECT_LT(rests.shakes_N, 1e-3);
  EXPECT_LT(rests.speed, 1e-6);
  EXPECT_LE(rests.last_N, kFriction * kWeight_N_per_kg * mass_kg + 0.02) << "friction bears what the hand presses";
  const Felt leaves = push(rate_Hz, late_s, mass_kg, 3, true);
  EXPECT_GE(leaves.least_J, -1e-6);
  EXPECT_EQ(leaves.last_N, 0);
  EXPECT_LT(leaves.speed, 1e-6);
  if (mass_kg < 1) {
    EXPECT_GT(leaves.pushed_m, 0.02);
  }
}

TEST(GuestPort, GivesTheMeanOfWhatTheHandFeltOfItsBodyAlone) {
  GuestPort port({.body = 7, .stiffness_N_per_m = 400, .exchange_s = 0.01});
  port.add({.ihip_m = {1, 2, 3}, .force_N = {0, 0, 2}, .touched = 7});
  port.add({.ihip_m = {1, 2, 4}, .force_N = {0, 0, 4}, .touched = 7});
  port.add({.ihip_m = {9, 9, 9}, .force_N = {5, 5, 5}, .touched = 8});
  const GuestPort::Wrench wrench = port.exchange();
  EXPECT_EQ(wrench.force_N, (GuestPort::Vector{0, 0, -2}));
  EXPECT_EQ(wrench.place_m, (GuestPort::Vector{1, 2, 4}));
  EXPECT_GT(wrench.damping_Ns_per_m, 0);
  EXPECT_EQ(port.exchange().force_N, wrench.force_N) << "no tick came";
  port.add({});
  EXPECT_EQ(port.exchange().force_N, GuestPort::Vector{});
}

TEST(GuestPort, CountsTheHandsWorkFromItsFirstTickOn) {
  GuestPort port({.body = 7, .stiffness_N_per_m = 400, .exchange_s = 0.01});
  port.add({.hip_m = {0, 0, 1}, .force_N = {0, 0, 2}, .touched = 7});
  EXPECT_NEAR(port.energy_J(), 5e-3, 1e-12) << "what the spring holds; where the hand was before is not known";
  port.add({.hip_m = {0, 0, 0.999}, .force_N = {0, 0, 4}, .touched = 7});
  EXPECT_NEAR(port.energy_J(), 8e-3, 1e-12);
  port.add({.hip_m = {0, 0, 0.998}, .force_N = {0, 0, 6}, .touched = 7, .missed = 5, .lost = 5});
  EXPECT_NEAR(port.energy_J(), 13e-3, 1e-12);
}

TEST(GuestPort, IsPaidForWhatAHandPressedWhileTheServoSlept) {
  constexpr int kSleeps = 10;
  for (const double mass_kg : {0.1, 10.0})
    EXPECT_GE(push(50, 0.02, mass_kg, 3, true, kSleeps).least_J, -1e-6) << mass_kg;
}

}  // namespace
}  // namespace haptics::guest_port_test
