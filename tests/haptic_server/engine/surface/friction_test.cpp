#include "haptic_server/engine/surface/friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace haptics::friction_test {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr FrictionCoefficients kMu{0.6, 0.3};
constexpr FrictionScale kScale{800 / 0.6, 330e-6};  // an encoder of 55 um
constexpr double kEncoder_m = 55e-6;
constexpr double kPressing_N = 2;
const Vec3 kUp(0, 0, 1);

/// Pressed on a plane with 2 N.
class OnAPlane {
 public:
  Vec3 at(double x, double y = 0) {
    const FrictionState before = friction.state();
    force = friction.follow({Vec3(x, y, 0), kUp, pressing_N}, kMu, kScale, kPeriod_s);
    toggles += before != FrictionState::kNone && before != friction.state() ? 1 : 0;
    return force;
  }
  /// From where it is, in steps of a tick.
  void slide(double from, double to, double speed_m_per_s) {
    const int steps = static_cast<int>(std::abs(to - from) / (speed_m_per_s * kPeriod_s));
    for (int i = 0; i <= steps; ++i) at(from + (to - from) * i / steps);
  }
  StickSlip friction;
  Vec3 force{0};
  double pressing_N = kPressing_N;
  int toggles = 0;
};

TEST(Friction, BeginsByStickingWhereTheSurfaceIsTouched) {
  OnAPlane plane;
  EXPECT_EQ(plane.at(0.01), Vec3(0));
  EXPECT_EQ(plane.friction.state(), FrictionState::kSticking);
  EXPECT_EQ(plane.friction.stickingPoint(), Vec3(0.01, 0, 0));
}

TEST(Friction, SticksAsASpringOfStiffnessProportionalToTheStaticCoefficient) {
  OnAPlane plane;
  plane.at(0);
  EXPECT_NEAR(plane.at(0.5e-3).x, -800 * 0.5e-3, 1e-12);
}

TEST(Friction, BreaksAwayAtTheStaticCoefficient) {
  OnAPlane plane;
  double most = 0;
  for (int i = 0; plane.friction.state() != FrictionState::kSliding; ++i) most = std::max(most, -plane.at(i * 5e-6).x);
  EXPECT_NEAR(most / kPressing_N, kMu.stick, 0.01 * kMu.stick);
}

TEST(Friction, SlidesWithTheDynamicCoefficient) {
  OnAPlane plane;
  plane.slide(0, 0.02, 0.05);
  EXPECT_EQ(plane.friction.state(), FrictionState::kSliding);
  EXPECT_NEAR(-plane.force.x / kPressing_N, kMu.slide, 1e-12);
}

TEST(Friction, PullsAgainstTheMotionInAnyDirection) {
  OnAPlane plane;
  for (int i = 0; i < 400; ++i) plane.at(6e-5 * i, 8e-5 * i);
  EXPECT_NEAR(plane.force.x, -kMu.slide * kPressing_N * 0.6, 1e-9);
  EXPECT_NEAR(plane.force.y, -kMu.slide * kPressing_N * 0.8, 1e-9);
}

TEST(Friction, DoesNotChatterInASlowSlideWithATremorOfAnEncoderStep) {
  OnAPlane plane;
  plane.slide(0, 0.01, 0.05);
  plane.toggles = 0;
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const double tremor = (static_cast<int>(random() % 3) - 1) * kEncoder_m;
    plane.pressing_N = 2 + 800 * (static_cast<int>(random() % 3) - 1) * kEncoder_m;
    plane.at(std::round((0.01 + 5e-6 * i) / kEncoder_m) * kEncoder_m + tremor);
  }
  EXPECT_EQ(plane.toggles, 0);
}

TEST(Friction, DoesNotCreepUnderATremor) {
  OnAPlane plane;
  plane.slide(0, 0.01, 0.05);
  std::mt19937 random(2);
  const auto tremble = [&] {
    plane.at(0.01 + (static_cast<int>(random() % 3) - 1) * kEncoder_m,
             (static_cast<int>(random() % 3) - 1) * kEncoder_m);
  };
  for (int i = 0; i < 500; ++i) tremble();  // comes to rest
  const Vec3 point = plane.friction.stickingPoint();
  for (int i = 0; i < 20000; ++i) tremble();
  EXPECT_EQ(plane.friction.stickingPoint(), point);
  EXPECT_EQ(plane.friction.state(), FrictionState::kSticking);
}

TEST(Friction, SticksAgainWithoutAStepOfTheForceWhenTheHandTurnsBack) {
  OnAPlane plane;
  plane.slide(0, 0.01, 0.05);
  double last = plane.force.x;
  double x = 0.01;
  for (; plane.friction.state() == FrictionState::kSliding; x -= 1e-5) {
    const double now = plane.at(x).x;
    EXPECT_LE(std::abs(now - last), 1.01 * 1e-5 * kScale.stiffness_N_per_m * kMu.stick);
    last = now;
  }
  EXPECT_NEAR(0.01 - x, kScale.hysteresis_m, 3e-5);
}

TEST(Friction, SticksAgainOnceTheHandRests) {
  OnAPlane plane;
  plane.slide(0, 0.01, 0.05);
  const double sliding = plane.force.x;
  for (int i = 0; i < 99; ++i) plane.at(0.01);
  EXPECT_EQ(plane.friction.state(), FrictionState::kSliding);
  for (int i = 0; i < 3; ++i) plane.at(0.01);
  EXPECT_EQ(plane.friction.state(), FrictionState::kSticking);
  EXPECT_NEAR(plane.force.x, sliding, 1e-12);
}

TEST(Friction, NeverGivesEnergyInAStrokeToAndFro) {
  OnAPlane plane;
  plane.at(0);
  double energy = 0, least = 0, x = 0;
  for (int i = 1; i < 20000; ++i) {
    const double next = 0.003 * std::sin(1e-3 * i) * std::cos(7.3e-4 * i);
    const Vec3 before = plane.force;
    plane.at(next);
    energy += (before.x + plane.force.x) / 2 * (next - x);  // given to the hand
    least = std::max(least, energy);
    x = next;
  }
  EXPECT_LT(least, 1e-6);
  EXPECT_LT(energy, -1e-3);
}

/// Waves of 1 mm at a slant, from 0.06 to 1.14.
FrictionCoefficients wavyMu(Vec3 place) {
  const double factor = 1 + 0.9 * std::sin(2 * std::numbers::pi * (0.6 * place.x + 0.8 * place.y) / 1e-3);
  return {0.6 * factor, 0.3 * factor};
}

TEST(Friction, ThatVariesGivesNoEnergyInALoopThatSticks) {
  constexpr FrictionScale kStiff{1000 / 1.14, 330e-6};
  for (const double x : {0.0, 0.2e-3, 0.7e-3}) {
    StickSlip friction;
    Vec3 last_m(x, 0, 0), last_N(0);
    double work_J = 0;
    for (int i = 0; i <= 20'000; ++i) {
      const double angle = 2 * std::numbers::pi * i / 2000;
      const Vec3 place(x + 0.35e-3 * (1 - std::cos(angle)), 0.35e-3 * std::sin(angle), 0);
      const Vec3 force_N = friction.follow({place, kUp, 5}, wavyMu(place), kStiff, kPeriod_s);
      ASSERT_EQ(friction.state(), FrictionState::kSticking);
      work_J += glm::dot(0.5 * (force_N + last_N), place - last_m);
      last_m = place;
      last_N = force_N;
    }
    EXPECT_NEAR(work_J, 0, 1e-9) << "ten loops from x = " << x;
  }
}

/// The static coefficient from 0.06 to 1.14, the dynamic one from 0.15 to 0.45 by other waves, but at most as large.
FrictionCoefficients twiceWavyMu(double x) {
  const double stick = 0.6 * (1 + 0.9 * std::sin(2 * std::numbers::pi * x / 5e-3));
  return {stick, std::min(stick, 0.3 * (1 + 0.5 * std::sin(2 * std::numbers::pi * x / 3e-3)))};
}

TEST(Friction, ThatVariesInTwoWaysSticksAgainWithoutAStepOfTheForce) {
  constexpr double kStep_m = 1e-6;
  const FrictionScale scale{800 / 1.14, 330e-6};
  for (int place = 0; place < 100; ++place) {
    StickSlip friction;
    double x = 1.7e-4 * place;
    const auto at = [&] {
      return friction.follow({Vec3(x, 0, 0), kUp, kPressing_N}, twiceWavyMu(x), scale, kPeriod_s).x;
    };
    at();
    for (int i = 0; i < 20'000; ++i, x += kStep_m) at();
    ASSERT_EQ(friction.state(), FrictionState::kSliding);
    double last = at();
    for (int i = 0; i < 2000 && friction.state() == FrictionState::kSliding; ++i) {
      x -= kStep_m;
      const double now = at();
      // The spring's share, and that of the waves' slope: 0.9 * 0.6 * 2 pi / 5 mm.
      EXPECT_LE(std::abs(now - last), kStep_m * (800 + 679 * kPressing_N)) << x;
      last = now;
    }
    EXPECT_EQ(friction.state(), FrictionState::kSticking);
  }
}

TEST(Friction, DoesNotStickWhereThereIsNone) {
  const auto mu = [](double x) { return x > 0 ? FrictionCoefficients{} : kMu; };
  StickSlip friction;
  for (double x = -0.01; x < 0.01; x += 1e-4) {
    const Vec3 force = friction.follow({Vec3(x, 0, 0), kUp, kPressing_N}, mu(x), kScale, kPeriod_s);
    if (x > 1e-9) {
      EXPECT_EQ(friction.state(), FrictionState::kNone) << x;
      EXPECT_EQ(force, Vec3(0)) << x;
    }
  }
  for (double x = 0.01; x > -0.01; x -= 1e-4) {
    (void)friction.follow({Vec3(x, 0, 0), kUp, kPressing_N}, mu(x), kScale, kPeriod_s);
  }
  EXPECT_EQ(friction.state(), FrictionState::kSliding) << "as before";
}

TEST(Friction, GivesWayWhenTheSurfaceIsPressedLess) {
  OnAPlane plane;
  plane.at(0);
  plane.at(1e-3);
  plane.pressing_N = 0.5;
  EXPECT_NEAR(-plane.at(1e-3).x, kMu.slide * 0.5, 1e-12);
}

TEST(Friction, ActsAlongTheSurfaceThoughTheStickingPointLiesOffItsTangentPlane) {
  StickSlip friction;
  (void)friction.follow({Vec3(0), kUp, kPressing_N}, kMu, kScale, kPeriod_s);
  const Vec3 normal = glm::normalize(Vec3(0.1, 0, 1));
  const Vec3 force = friction.follow({Vec3(1e-4, 0, 1e-4), normal, kPressing_N}, kMu, kScale, kPeriod_s);
  EXPECT_NEAR(glm::dot(force, normal), 0, 1e-15);
  EXPECT_LT(force.x, 0);
}

}  // namespace
}  // namespace haptics::friction_test
