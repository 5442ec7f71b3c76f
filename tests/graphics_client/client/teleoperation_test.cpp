#include "graphics_client/client/teleoperation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace haptics::teleoperation_test {
namespace {

using Vector = TeleoperationPort::Vector;

constexpr TeleoperationPort::Settings kExact{.maxForce_N = 10};

/// A follower that is pressed upwards, as the master hears it.
TeleoperationPacket pressed(std::uint64_t tick, double force_N, double given_J) {
  return {.tick = tick, .force_N = {0, 0, force_N}, .given_J = given_J, .spare_J = 1};
}

/// Ticks of a hand that stands still; the force in the end.
double still(MasterPort& master, int ticks) {
  double force_N = 0;
  for (int i = 0; i < ticks; ++i) force_N = master.tick({})[2];
  return force_N;
}

TEST(MasterPort, PushesTheHandNoHarderThanWasPaidFor) {
  MasterPort master(kExact);
  master.receive(pressed(1, 3, 0));
  EXPECT_EQ(still(master, 300), 0) << "nobody has put anything in";
  master.receive(pressed(2, 3, 0.3e-3));
  const double force_N = still(master, 300);
  EXPECT_NEAR(force_N * force_N / (2 * 3000), 0.3e-3, 1e-6);
  // Pushed away, the hand gets that and no more.
  double got_J = 0, at_m = 0;
  for (int i = 0; i < 400; ++i) {
    if (i % 100 == 0) master.receive(pressed(3 + static_cast<std::uint64_t>(i), 3, 0.3e-3));
    const double now_N = master.tick({0, 0, at_m})[2];
    at_m += 1e-5;
    got_J += 1e-5 * now_N;
  }
  EXPECT_GT(got_J, 0.2e-3);
  EXPECT_LE(got_J, 0.3e-3);
  EXPECT_GE(master.lowest_J(), 0);
}

TEST(MasterPort, ResistsAHandThatPressesAgainstWhatIsToldAndShowsItThen) {
  MasterPort master(kExact);
  master.receive(pressed(1, 2, 0));
  double at_m = 0, put_J = 0;
  for (int i = 0; i < 450; ++i) {
    const double now_N = master.tick({0, 0, at_m})[2];
    at_m -= 2e-5;
    put_J += 2e-5 * now_N;
  }
  EXPECT_NEAR(master.tick({0, 0, at_m})[2], 2, 0.05);
  EXPECT_GT(put_J, 2 * 2 / (2 * 3000.0));
}

TEST(MasterPort, BringsALightHandAtCoarseEncodersToRest) {
  constexpr double kResolution_m = 60e-6, kMass_kg = 0.3, kGrip_N_per_m = 100, kViscous_Ns_per_m = 1, kCoulomb_N = 0.01;
  constexpr double kReach_m = 0.01, kComes_s = 0.4, kLatestRest_s = 1.4, kEnd_s = 2.4, kTick_s = 1e-3, kStep_s = 1e-4;
  for (double offset_m = 0; offset_m < kResolution_m; offset_m += kResolution_m / 20) {
    MasterPort master({.maxForce_N = 8, .resolution_m = kResolution_m});
    double at_m = offset_m, speed = 0, rested_m = 0, strays_m = 0;
    for (int n = 1; n * kTick_s <= kEnd_s; ++n) {
      const double t = n * kTick_s, meant_m = -kReach_m * std::min(1.0, t / kComes_s);
      if (n % 30 == 1) master.receive({.tick = static_cast<std::uint64_t>(n), .force_N = {0, 0, 1.75}, .spare_J = -1});
      const double shown_N = master.tick({0, 0, std::round(at_m / kResolution_m) * kResolution_m})[2];
      for (int i = 0; i < 10; ++i) {
        speed += kStep_s / kMass_kg * (shown_N + kGrip_N_per_m * (meant_m - at_m) - kViscous_Ns_per_m * speed);
        speed = std::copysign(std::max(0.0, std::abs(speed) - kStep_s / kMass_kg * kCoulomb_N), speed);
        at_m += kStep_s * speed;
      }
      if (t <= kLatestRest_s) rested_m = at_m;
      strays_m = std::max(strays_m, std::abs(at_m - rested_m));
    }
    EXPECT_LT(strays_m, 2 * kResolution_m) << offset_m;
  }
}

TEST(MasterPort, TakesNoPacketThatIsOldOrNotFinite) {
  MasterPort master(kExact);
  master.receive(pressed(5, 1, 1e-3));
  const double held_J = master.held_J();
  EXPECT_EQ(held_J, 1e-3);
  master.receive(pressed(5, 1, 2e-3));
  master.receive(pressed(4, 1, 3e-3));
  master.receive(pressed(6, std::numeric_limits<double>::quiet_NaN(), 2e-3));
  master.receive(pressed(6, 1, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(master.held_J(), held_J);
  master.receive(pressed(7, 1, 2e-3));
  EXPECT_EQ(master.held_J(), 2e-3) << "a lost packet takes nothing away";
}

TEST(MasterPort, LetsGoWhereNobodyIsHeard) {
  MasterPort master(kExact);
  master.receive(pressed(1, 1, 1));
  EXPECT_NEAR(still(master, 400), 1, 1e-3);
  EXPECT_NEAR(still(master, 400), 0, 1e-3);
}

TEST(FollowerPort, SendsWhatIsNoticedAndOtherwiseNowAndThen) {
  FollowerPort follower(kExact);
  const auto sent = [&](double force_N, int ticks) {
    int packets = 0;
    for (int i = 0; i < ticks; ++i) {
      follower.tick({}, {0, 0, force_N});
      if (follower.send()) ++packets;
    }
    return packets;
  };
  EXPECT_EQ(sent(1, 301), 11) << "one at once, then one in 30 ms";
  EXPECT_EQ(sent(1.06, 27), 0);
  EXPECT_EQ(sent(1.08, 1), 1);
  EXPECT_EQ(sent(1.08, 29), 0);
}

TEST(FollowerPort, MovesByWhatTheMasterGaveAlone) {
  FollowerPort follower(kExact);
  TeleoperationPacket ahead{.tick = 1, .place_m = {0.01, 0, 0}};
  follower.receive(ahead);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(follower.tick({}, {})[0], 0);
  ahead.tick = 2;
  ahead.given_J = 1e-3;
  follower.receive(ahead);
  const double force_N = follower.tick({}, {})[0];
  EXPECT_NEAR(force_N * force_N / (2 * 600), 1e-3, 1e-6);
}

}  // namespace
}  // namespace haptics::teleoperation_test
