#include <gtest/gtest.h>

#include "haptic_server/engine/force/predictive_observer.h"

namespace haptics::predictive_observer_tests {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr double kStiffness_N_per_m = 1000;
constexpr ObserverSettings kKnown{.mass_kg = 0.1, .viscousFriction_Ns_per_m = 0.3, .delay_s = 0, .bandwidth_Hz = 80};

/// m x'' + b x' = F exactly, one axis, the force constant for so long.
struct Mass {
  double position_m = 0, velocity_m_per_s = 0;
  void move(double force_N, double time_s) {
    const double m = kKnown.mass_kg, b = kKnown.viscousFriction_Ns_per_m;
    const double fade = std::exp(-b / m * time_s);
    const double most = force_N / b;
    position_m += most * time_s + (velocity_m_per_s - most) * m / b * (1 - fade);
    velocity_m_per_s = most + (velocity_m_per_s - most) * fade;
  }
};

double forceAt(int tick) { return 2 * std::sin(0.05 * tick) + (tick % 7 == 0 ? 0.5 : 0); }

TEST(PredictiveObserver, ForeseesAMovementAtConstantSpeedInTheMiddleOfTheForcesTime) {
  for (const double delay_s : {0.0, 0.3e-3, 1e-3, 2.5e-3}) {
    ObserverSettings settings;
    settings.delay_s = delay_s;
    PredictiveObserver observer(settings, kPeriod_s);
    observer.reset(Vec3(0));
    const Vec3 velocity(0.1, -0.05, 0.02);
    Vec3 foreseen(0);
    Vec3 place(0);
    for (int i = 0; i < 300; ++i) {
      foreseen = observer.follow(place = velocity * (kPeriod_s * i));
      if (i + 1 < 300) observer.onForceWritten(Vec3(0), Vec3(0), 0);
    }
    EXPECT_LT(glm::distance(foreseen, place + velocity * (kPeriod_s / 2 + delay_s)), 1e-9) << delay_s;
    EXPECT_LT(glm::distance(observer.velocity(), velocity), 1e-9);
  }
}

TEST(PredictiveObserver, LooksFartherAheadAlongTheContactNormalAndNowhereElse) {
  PredictiveObserver observer(ObserverSettings{}, kPeriod_s);
  observer.reset(Vec3(0));
  const Vec3 velocity(0.1, 0, 0.2);
  Vec3 foreseen(0);
  Vec3 place(0);
  for (int i = 0; i < 300; ++i) {
    foreseen = observer.follow(place = velocity * (kPeriod_s * i));
    observer.onForceWritten(Vec3(0), Vec3(0, 0, 1), kStiffness_N_per_m);
  }
  EXPECT_NEAR(foreseen.x - place.x, 0.1 * kPeriod_s / 2, 1e-9);
  EXPECT_NEAR(foreseen.z - place.z, 0.2 * (kPeriod_s / 2 + ObserverSettings{}.contactLead_s), 1e-9);
}

TEST(PredictiveObserver, LooksAheadAlongTheNormalOfTheSurfaceThatWasLeftUntilAnotherIsTouched) {
  PredictiveObserver observer(ObserverSettings{}, kPeriod_s);
  observer.reset(Vec3(0));
  const Vec3 velocity(0.1, 0, 0.2);
  Vec3 place(0);
  const auto ahead = [&](Vec3 normal) {
    Vec3 foreseen(0);
    for (int i = 0; i < 300; ++i) {
      foreseen = observer.follow(place += velocity * kPeriod_s);
      observer.onForceWritten(Vec3(0), normal, kStiffness_N_per_m);
    }
    return foreseen - place;
  };
  constexpr double kShort_s = kPeriod_s / 2, kLong_s = kShort_s + ObserverSettings{}.contactLead_s;
  EXPECT_NEAR(ahead(Vec3(0)).z, 0.2 * kShort_s, 1e-9);
  EXPECT_NEAR(ahead({0, 0, 1}).z, 0.2 * kLong_s, 1e-9);
  EXPECT_NEAR(ahead(Vec3(0)).z, 0.2 * kLong_s, 1e-9);
  EXPECT_NEAR(ahead({1, 0, 0}).z, 0.2 * kShort_s, 1e-9);
  EXPECT_NEAR(ahead({1, 0, 0}).x, 0.1 * kLong_s, 1e-9);
}

TEST(PredictiveObserver, DoesNotLeadWhatGoesAlongWithAMovingSurface) {
  PredictiveObserver observer(ObserverSettings{}, kPeriod_s);
  observer.reset(Vec3(0));
  constexpr double kSpeed_m_per_s = 0.2;
  double foreseen_m = 0;
  double place_m = 0;
  for (int i = 0; i < 300; ++i) {
    place_m = kSpeed_m_per_s * kPeriod_s * i;
    foreseen_m = observer.follow({0, 0, place_m}).z;
    observer.onForceWritten(Vec3(0), Vec3(0, 0, 1), kStiffness_N_per_m, kSpeed_m_per_s);
  }
  EXPECT_NEAR(foreseen_m - place_m, kSpeed_m_per_s * kPeriod_s / 2, 1e-9);
}

/// A device whose every force it is told foresees its place though that is on no smooth path: the error is what a hold's
/// friction leaves, micrometres.
TEST(PredictiveObserver, KnowsWhatTheForcesThatAreStillOnTheirWayWillDo) {
  for (const int delayTicks : {0, 1, 3}) {
    ObserverSettings settings = kKnown;
    settings.delay_s = delayTicks * kPeriod_s;
    PredictiveObserver observer(settings, kPeriod_s);
    ObserverSettings ignorant = settings;
    ignorant.mass_kg = 0;
    PredictiveObserver without(ignorant, kPeriod_s);
    observer.reset(Vec3(0));
    without.reset(Vec3(0));
    Mass mass;
    double worst_m = 0;
    double worstWithout_m = 0;
    for (int tick = 0; tick < 600; ++tick) {
      const double foreseen_m = observer.follow({mass.position_m, 0, 0}).x;
      const double without_m = without.follow({mass.position_m, 0, 0}).x;
      observer.onForceWritten({forceAt(tick), 0, 0}, Vec3(0), 0);
      without.onForceWritten({forceAt(tick), 0, 0}, Vec3(0), 0);
      Mass coming = mass;
      for (int i = 0; i < delayTicks; ++i) coming.move(forceAt(tick - delayTicks + i), kPeriod_s);
      coming.move(forceAt(tick), kPeriod_s / 2);
      if (tick > 300) {
        worst_m = std::max(worst_m, std::abs(foreseen_m - coming.position_m));
        worstWithout_m = std::max(worstWithout_m, std::abs(without_m - coming.position_m));
      }
      mass.move(forceAt(tick - delayTicks), kPeriod_s);
    }
    EXPECT_LT(worst_m, 2e-6) << delayTicks;
    EXPECT_GT(worstWithout_m, 5 * worst_m) << delayTicks;
  }
}

TEST(PredictiveObserver, SmoothsTheStepsOfAnEncoder) {
  PredictiveObserver observer(ObserverSettings{}, kPeriod_s);
  observer.reset(Vec3(0));
  constexpr double kStep_m = 55e-6;
  EXPECT_LT(observer.follow(Vec3(kStep_m, 0, 0)).x, 1.5 * kStep_m);
  for (int i = 0; i < 200; ++i) {
    observer.onForceWritten(Vec3(0), Vec3(0), 0);
    (void)observer.follow(Vec3(kStep_m, 0, 0));
  }
  EXPECT_NEAR(observer.follow(Vec3(kStep_m, 0, 0)).x, kStep_m, 1e-12);
}

constexpr ObserverSettings kScheduled{
    .bandwidth_Hz = 70, .hardBandwidth_Hz = 210, .softUpTo_N_per_m = 1000, .hardFrom_N_per_m = 2500};

/// Of a step of the encoder, as far as it is foreseen in its first tick after a rest on such a surface.
double partForeseen(const ObserverSettings& settings, Vec3 normal, double stiffness_N_per_m) {
  PredictiveObserver observer(settings, kPeriod_s);
  observer.reset(Vec3(0));
  (void)observer.follow(Vec3(0));
  observer.onForceWritten(Vec3(0), normal, stiffness_N_per_m);
  return observer.follow(Vec3(1, 0, 0)).x;
}

TEST(PredictiveObserver, FollowsFasterTheHarderTheTouchedSurfaceIsAndFastestInTheAir) {
  const auto steady = [](double bandwidth_Hz, Vec3 normal) {
    return partForeseen({.bandwidth_Hz = bandwidth_Hz, .hardBandwidth_Hz = bandwidth_Hz}, normal, kStiffness_N_per_m);
  };
  constexpr Vec3 kTouched(1, 0, 0);
  for (const double soft : {0.0, 300.0, 1000.0}) {
    EXPECT_DOUBLE_EQ(partForeseen(kScheduled, kTouched, soft), steady(70, kTouched)) << soft;
  }
  for (const double hard : {2500.0, 30e3}) {
    EXPECT_DOUBLE_EQ(partForeseen(kScheduled, kTouched, hard), steady(210, kTouched)) << hard;
  }
  EXPECT_DOUBLE_EQ(partForeseen(kScheduled, Vec3(0), 0), steady(210, Vec3(0)));
  double last = steady(70, kTouched);
  for (const double between : {1200.0, 1800.0, 2400.0}) {
    const double part = partForeseen(kScheduled, kTouched, between);
    EXPECT_GT(part, last) << between;
    last = part;
  }
  EXPECT_LT(last, steady(210, kTouched));
}

/// On a movement that it has understood there is nothing to weigh: a step would be felt as one of the force.
TEST(PredictiveObserver, ForeseesNoStepWhenTheSurfaceBecomesHarderOrSofter) {
  PredictiveObserver observer(kScheduled, kPeriod_s);
  observer.reset(Vec3(0));
  const Vec3 velocity(0.1, 0, -0.2);
  const Vec3 ahead = kPeriod_s / 2 * velocity + kScheduled.contactLead_s * Vec3(0, 0, velocity.z);
  Vec3 place(0);
  for (int i = 0; i < 600; ++i) {
    const Vec3 foreseen = observer.follow(place += velocity * kPeriod_s);
    observer.onForceWritten(Vec3(0), Vec3(0, 0, 1), i % 3 == 0 ? 500 : i % 3 == 1 ? 1700 : 9000);
    if (i <= 300) continue;
    EXPECT_LT(glm::distance(foreseen, place + ahead), 1e-9) << i;
  }
}

TEST(PredictiveObserver, GoesOnOverSkippedTicksUnderTheForceThatStood) {
  PredictiveObserver observer(kKnown, kPeriod_s);
  observer.reset(Vec3(0));
  Mass mass;
  for (int tick = 0; tick < 300; ++tick) {
    (void)observer.follow({mass.position_m, 0, 0});
    observer.onForceWritten({0.2, 0, 0}, Vec3(0), 0);
    mass.move(0.2, kPeriod_s);
  }
  const double before_m_per_s = observer.velocity().x;
  constexpr int kSkipped = 10;
  observer.skip(kSkipped);
  mass.move(0.2, kSkipped * kPeriod_s);
  (void)observer.follow({mass.position_m, 0, 0});
  EXPECT_NEAR(observer.velocity().x, mass.velocity_m_per_s, 0.02 * (mass.velocity_m_per_s - before_m_per_s));
}

/// The steps are seen as some m/s^2 and cm/s: led on for the time of a stall, they would be half a millimetre.
TEST(PredictiveObserver, LeadsNoEncoderStepsOverSkippedTicks) {
  constexpr double kStep_m = 55e-6;
  const ObserverSettings settings{.bandwidth_Hz = 80};
  for (int before = 200; before < 400; ++before) {
    PredictiveObserver observer(settings, kPeriod_s);
    observer.reset(Vec3(0));
    const auto place = [](int tick) { return 0.03 * kPeriod_s * tick; };
    const auto foreseen = [&](int tick) {
      const double seen = observer.follow({kStep_m * std::round(place(tick) / kStep_m), 0, 0}).x;
      observer.onForceWritten(Vec3(0), Vec3(0), 0);
      return seen - place(tick);
    };
    for (int tick = 0; tick < before; ++tick) (void)foreseen(tick);
    constexpr int kSkipped = 17;
    observer.skip(kSkipped);
    for (int tick = before + kSkipped; tick < before + kSkipped + 10; ++tick)
      EXPECT_LT(std::abs(foreseen(tick)), 2 * kStep_m) << before << ' ' << tick;
  }
}

TEST(PredictiveObserver, ForgetsEverythingWhenItIsReset) {
  PredictiveObserver observer(kKnown, kPeriod_s);
  observer.reset(Vec3(0));
  for (int i = 0; i < 50; ++i) {
    (void)observer.follow(Vec3(1e-4 * i));
    observer.onForceWritten(Vec3(1, 2, 3), Vec3(0, 0, 1), kStiffness_N_per_m);
  }
  observer.reset(Vec3(0.3));
  EXPECT_EQ(observer.follow(Vec3(0.3)), Vec3(0.3));
}

}  // namespace
}  // namespace haptics::predictive_observer_tests
