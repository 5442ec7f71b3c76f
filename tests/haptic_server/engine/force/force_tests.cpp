#include <gtest/gtest.h>

#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/force/spring_damper.h"
#include "haptic_server/engine/force/velocity_estimator.h"

namespace haptics::force_tests {
namespace {

constexpr double kPeriod_s = 1e-3;

TEST(VelocityEstimator, FindsTheVelocityOfARamp) {
  VelocityEstimator estimator(kPeriod_s);
  estimator.reset(Vec3(0));
  Vec3 velocity(0);
  for (int i = 1; i <= 200; ++i) velocity = estimator.update(Vec3(0.1, -0.05, 0) * (kPeriod_s * i));
  EXPECT_NEAR(velocity.x, 0.1, 1e-9);
  EXPECT_NEAR(velocity.y, -0.05, 1e-9);
}

TEST(VelocityEstimator, GoesOnOverSkippedTicks) {
  VelocityEstimator estimator(kPeriod_s);
  estimator.reset(Vec3(0));
  for (int i = 1; i <= 200; ++i) estimator.update(Vec3(0.1 * kPeriod_s * i, 0, 0));
  estimator.skip(17);
  EXPECT_NEAR(estimator.update(Vec3(0.1 * kPeriod_s * 218, 0, 0)).x, 0.1, 1e-6);
}

TEST(VelocityEstimator, LetsAnEncoderStepThroughAsLessThanAQuarterOfARawDifference) {
  VelocityEstimator estimator(kPeriod_s);
  estimator.reset(Vec3(0));
  constexpr double kStep_m = 55e-6;
  EXPECT_LT(estimator.update(Vec3(kStep_m, 0, 0)).x, 0.25 * kStep_m / kPeriod_s);
}

TEST(VelocityEstimator, IsCriticallyDamped) {
  VelocityEstimator estimator(kPeriod_s);
  estimator.reset(Vec3(0));
  for (int i = 0; i < 300; ++i) EXPECT_GE(estimator.update(Vec3(1, 0, 0)).x, -1e-9);
}

TEST(SpringDamper, PushesOutWithHookesLaw) {
  const auto f = springDamper(0.002, Vec3(0, 0, 1), 0, {1000, 5});
  EXPECT_NEAR(f.spring.z, 2.0, 1e-12);
  EXPECT_EQ(f.damping, Vec3(0));
}

TEST(SpringDamper, DampsPressingInAndNeverPullsWhenLifted) {
  const auto in = springDamper(0.002, Vec3(0, 0, 1), -0.1, {1000, 5});
  EXPECT_NEAR(in.damping.z, 0.5, 1e-12);
  const auto out = springDamper(0.002, Vec3(0, 0, 1), 10, {1000, 5});
  EXPECT_NEAR(out.spring.z + out.damping.z, 0, 1e-12);
}

constexpr double kMax_N = 100;  // of a device

TEST(RateLimitedStiffness, IsThereAtOnceWithoutContact) {
  RateLimitedStiffness felt;
  felt.follow({800, 1}, 0, 0, kMax_N, kPeriod_s);
  EXPECT_EQ(felt.value(), (Stiffness{800, 1}));
}

TEST(RateLimitedStiffness, NeverChangesTheForceFasterThanItsRateAndArrives) {
  RateLimitedStiffness felt;
  felt.follow({200, 0}, 0, 0, kMax_N, kPeriod_s);
  const double penetration = 0.005;
  const Stiffness target{3000, 2};
  double force = 200 * penetration;
  int ticks = 0;
  for (; felt.value() != target && ticks < 2000; ++ticks) {
    felt.follow(target, penetration, 0, kMax_N, kPeriod_s);
    const double next = felt.value().spring_N_per_m * penetration;
    EXPECT_LE(next - force, RateLimitedStiffness::kRate_N_per_s * kPeriod_s + 1e-12);
    force = next;
  }
  EXPECT_NEAR(ticks, (3000 - 200) * penetration / RateLimitedStiffness::kRate_N_per_s / kPeriod_s, 2);
}

TEST(RateLimitedStiffness, LosesAtOnceWhatTheDeviceCannotShow) {
  constexpr double kDepth_m = 0.01;
  RateLimitedStiffness felt;
  felt.follow({3000, 0}, 0, 0, 8, kPeriod_s);
  felt.follow({}, kDepth_m, 0, 8, kPeriod_s);
  EXPECT_NEAR(felt.value().spring_N_per_m * kDepth_m, 8 - RateLimitedStiffness::kRate_N_per_s * kPeriod_s, 1e-9);
}

TEST(RateLimitedStiffness, IsANumberAgainAfterADepthThatWasNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RateLimitedStiffness felt;
  felt.follow({200, 1}, 0, 0, kMax_N, kPeriod_s);
  EXPECT_EQ(felt.follow({800, 1}, nan, nan, kMax_N, kPeriod_s), 0);
  felt.follow({800, 1}, 0.005, 0, kMax_N, kPeriod_s);
  EXPECT_EQ(felt.value(), (Stiffness{800, 1}));
}

TEST(RateLimitedStiffness, FollowsAnEditAtItsRateWhateverItsFactorIs) {
  constexpr double kDepth_m = 0.005, kFactor = 1.8;
  RateLimitedStiffness felt;
  felt.follow({200, 1}, 0, 0, kMax_N, kPeriod_s);
  felt.vary(kFactor);
  EXPECT_EQ(felt.value(), (Stiffness{200 * kFactor, kFactor}));
  EXPECT_EQ(felt.mean(), (Stiffness{200, 1}));
  double put_J = 0;
  for (int ticks = 0; felt.mean() != Stiffness{800, 1} && ticks < 2000; ++ticks) {
    const double before_N = felt.value().spring_N_per_m * kDepth_m;
    put_J += felt.follow({800, 1}, kDepth_m, 0, kMax_N, kPeriod_s);
    EXPECT_LE(felt.value().spring_N_per_m * kDepth_m - before_N,
              RateLimitedStiffness::kRate_N_per_s * kPeriod_s + 1e-12);
  }
  EXPECT_NEAR(put_J, 600 * kFactor * kDepth_m * kDepth_m / 2, 1e-12);
}

TEST(RateLimitedStiffness, IsAsItWasWhereAnEditChangesItsFactor) {
  RateLimitedStiffness felt;
  felt.follow({200, 1}, 0, 0, kMax_N, kPeriod_s);
  felt.vary(2);
  felt.varyByEdit(0.5);
  EXPECT_EQ(felt.value(), (Stiffness{400, 2}));
  EXPECT_EQ(felt.mean(), (Stiffness{800, 4}));
  felt.vary(1);
  EXPECT_EQ(felt.value(), (Stiffness{800, 4}));
}

TEST(EditSlew, LetsAnEditInAtItsRateWhileTheHandRests) {
  EditSlew slew;
  const Stiffness k{1000, 1};
  Vec3 written(0, 0, 2);
  const Vec3 felt(1, 0, 0);
  slew.begin();
  int ticks = 0;
  for (; written != felt && ticks < 1000; ++ticks) {
    const Vec3 next = slew.follow(written, felt, Vec3(0), Vec3(0), 0, k, true, kPeriod_s);
    EXPECT_LE(glm::distance(next, written), EditSlew::kRate_N_per_s * kPeriod_s + 1e-12);
    written = next;
  }
  EXPECT_NEAR(ticks, std::sqrt(5.0) / (EditSlew::kRate_N_per_s * kPeriod_s), 1);
}

TEST(EditSlew, LeavesTheContactOfAMovingHandAsItIs) {
  EditSlew slew;
  const Stiffness k{1000, 0};
  slew.begin();
  Vec3 written = slew.follow(Vec3(0), Vec3(0), Vec3(0), Vec3(0), 0, k, false, kPeriod_s);
  for (int i = 1; i <= 20; ++i) {
    const Vec3 hip(0, 0, -0.3e-3 * i);  // into a wall
    const Vec3 felt(0, 0, 0.3 * i);
    written = slew.follow(written, felt, hip, hip, 0, k, false, kPeriod_s);
    EXPECT_EQ(written, felt);
  }
}

TEST(EditSlew, LetsAnEditInNoSoonerWhileTheHandMoves) {
  EditSlew slew;
  const Stiffness k{1000, 0};
  slew.begin();
  Vec3 written = slew.follow(Vec3(0, 0, 3), Vec3(0, 0, 1), Vec3(0), Vec3(0), 0, k, true, kPeriod_s);
  for (int i = 0; i < 60; ++i) {
    const Vec3 felt(0, 0, 1 + (i % 2 == 0 ? 0.1 : 0));
    const Vec3 hip(0, 0, i % 2 == 0 ? -0.1e-3 : 0);
    const Vec3 next = slew.follow(written, felt, hip, hip, 0, k, false, kPeriod_s);
    EXPECT_LE(glm::distance(next, written), 0.1 + EditSlew::kRate_N_per_s * kPeriod_s + 1e-12);
    written = next;
  }
  EXPECT_GT(written.z, 1.05);
}

TEST(EditSlew, TakesWhatAnObserverMakesOfAHandAtRestForTheEdits) {
  EditSlew slew;
  const Stiffness k{1000, 0};
  slew.begin();
  Vec3 written = slew.follow(Vec3(0), Vec3(0), Vec3(0), Vec3(0), 0, k, false, kPeriod_s);
  for (int i = 1; i <= 20; ++i) {
    const Vec3 next =
        slew.follow(written, Vec3(0, 0, 0.1 * i), Vec3(0), Vec3(0, 0, -0.1e-3 * i), 0, k, false, kPeriod_s);
    EXPECT_LE(glm::distance(next, written), EditSlew::kRate_N_per_s * kPeriod_s + 1e-12);
    written = next;
  }
}

TEST(EditSlew, EndsOnceTheForceHasNotBeenLimitedForAWhile) {
  EditSlew slew;
  EXPECT_FALSE(slew.active());
  slew.begin();
  int ticks = 0;
  for (; slew.active(); ++ticks) (void)slew.follow(Vec3(0), Vec3(0, 0, 0.6), Vec3(0), Vec3(0), 0, {}, false, kPeriod_s);
  EXPECT_NEAR(ticks * kPeriod_s, 0.6 / EditSlew::kRate_N_per_s + EditSlew::kSettled_s, 3 * kPeriod_s);
}

TEST(LimitMagnitude, KeepsTheDirection) {
  const Vec3 limited = limitMagnitude(Vec3(30, 40, 0), 5);
  EXPECT_NEAR(limited.x, 3, 1e-12);
  EXPECT_NEAR(limited.y, 4, 1e-12);
  EXPECT_EQ(limitMagnitude(Vec3(1, 2, 2), 5), Vec3(1, 2, 2));
}

TEST(FaultRamp, TakesTheForceAwayWithin25MillisecondsAndGivesItBackWhenAllIsWell) {
  FaultRamp ramp;
  Vec3 force(0, 0, 2);
  for (int i = 0; i < 25; ++i) force = ramp.apply(true, Vec3(0, 0, 2), kPeriod_s);
  EXPECT_EQ(force.z, 0);
  EXPECT_TRUE(ramp.atZero());
  ramp.begin(0);
  EXPECT_EQ(ramp.apply(false, Vec3(0, 0, 2), kPeriod_s), Vec3(0, 0, 2));
}

TEST(FaultRamp, LetsTheForceComeInTheTimeThatIsAskedFor) {
  FaultRamp ramp;
  constexpr double kRise_s = 0.1;
  ramp.begin(kRise_s);
  double last_N = 0;
  for (int i = 1; i <= 100; ++i) {
    const double force_N = ramp.apply(false, Vec3(0, 0, 2), kPeriod_s).z;
    EXPECT_NEAR(force_N - last_N, 2 * kPeriod_s / kRise_s, 1e-9);
    last_N = force_N;
  }
  EXPECT_NEAR(ramp.apply(false, Vec3(0, 0, 2), kPeriod_s).z, 2, 1e-9);
  EXPECT_LT(ramp.apply(true, Vec3(0, 0, 2), kPeriod_s).z, 2);
}

TEST(DeadlineWatch, CountsTicksInARowThatNeverCameAndForgetsThemAfterOneOnTime) {
  DeadlineWatch watch;
  EXPECT_EQ(watch.missed(100), 0U) << "the first tick may have any number";
  EXPECT_EQ(watch.missed(101), 0U);
  EXPECT_EQ(watch.missed(131), 29U);
  EXPECT_FALSE(watch.tooMany(kPeriod_s));
  EXPECT_EQ(watch.missed(153), 21U);
  EXPECT_TRUE(watch.tooMany(kPeriod_s));
  EXPECT_EQ(watch.missed(154), 0U);
  EXPECT_FALSE(watch.tooMany(kPeriod_s));
  EXPECT_EQ(watch.missed(0), 0U) << "a new count";
}

TEST(DeadlineWatch, KeepsTheForceAwayForLongerEachTimeThatItIsTakenAwaySoonAfterItsReturn) {
  DeadlineWatch watch;
  std::uint64_t tick = 1000;
  const auto giveUp = [&] {
    watch.giveUp(tick, kPeriod_s);
    const double wait_s = watch.wait_s(tick, kPeriod_s);
    tick += static_cast<std::uint64_t>(wait_s / kPeriod_s);
    EXPECT_EQ(watch.wait_s(tick, kPeriod_s), 0);
    tick += 70;
    return wait_s;
  };
  EXPECT_EQ(giveUp(), 0);
  for (const double wait_s : {2, 4, 8, 16, 30, 30}) EXPECT_NEAR(giveUp(), wait_s, kPeriod_s);
  tick += 2000;
  EXPECT_EQ(giveUp(), 0) << "it held for 2 s";
}

}  // namespace
}  // namespace haptics::force_tests
