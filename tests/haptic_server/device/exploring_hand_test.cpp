#include "haptic_server/device/exploring_hand.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

namespace haptics::exploring_hand_test {
namespace {

constexpr double kPeriod = 1e-3;        // s
constexpr double kUpToPeak = 15.0 / 8;  // peak speed of a minimum-jerk movement in units of its mean

HandPreset nominal() { return findHandPreset("nominal").value(); }

Stroke row(std::uint64_t object, Vec3 start, int points = 21) {
  Stroke stroke{object, {}, false};
  for (int i = 0; i < points; ++i) stroke.points.push_back(start + Vec3(0.002 * i, 0, 0));
  return stroke;
}

std::unique_ptr<ExplorationPlan> planOf(std::vector<Stroke> strokes, double clearHeight = 0.1) {
  return std::make_unique<ExplorationPlan>(ExplorationPlan{std::move(strokes), clearHeight});
}

ExploringHand following(const std::unique_ptr<ExplorationPlan>& plan) {
  ExploringHand hand(nominal(), 3.3);
  hand.follow(plan.get());
  return hand;
}

/// A hand without inertia over a springy ground: it is where it intends to be, less what its own compliance yields.
class Rubbing {
 public:
  explicit Rubbing(double ground_z = 0) : ground_(ground_z) {}

  Vec3 tick(ExploringHand& hand) {
    position_ = hand.next(kPeriod, {0, 0, force_}).position;
    constexpr double kGroundAndHand = 1 / (1 / 800.0 + 1 / 300.0);  // N/m
    force_ = std::max(0.0, kGroundAndHand * (ground_ - position_.z));
    return position_;
  }
  double force() const { return force_; }
  void moveGround(double z) { ground_ = z; }

 private:
  double ground_;
  double force_ = 0;
  Vec3 position_{0};
};

/// Ticks until the hand has pressed and is in the middle of a stroke.
void runIntoStroke(ExploringHand& hand, Rubbing& world, Vec3 start) {
  for (int i = 0; i < 10000; ++i) {
    const Vec3 p = world.tick(hand);
    if (world.force() > 1 && std::abs(p.x - start.x) > 0.015) return;
  }
  FAIL() << "the hand never stroked";
}

TEST(Reach, StartsAndEndsAtRestAndNeverTurnsBack) {
  Reach reach{{0, 0, 0}, {1, 0, 0}, 2, 0};
  double last = 0;
  for (int i = 0; i <= 2000; ++i) {
    reach.elapsed_s = i * 1e-3;
    const double now = reach.position().x;
    EXPECT_GE(now, last);
    EXPECT_LE((now - last) / 1e-3, kUpToPeak / 2 * 1.0001);
    last = now;
  }
  EXPECT_EQ(last, 1);
  EXPECT_TRUE(reach.done());
  reach.elapsed_s = 1e-3;
  EXPECT_LT(reach.position().x, 2e-9);  // 10 s^3
  reach.elapsed_s = 5;
  EXPECT_EQ(reach.position().x, 1);
}

TEST(ExploringHand, RestsWithoutAPlan) {
  ExploringHand hand(nominal(), 3.3);
  const Vec3 start = hand.next(0, Vec3(0)).position;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(hand.next(kPeriod, Vec3(0)).position, start);
  hand.follow(nullptr);
  const ExplorationPlan empty;
  hand.follow(&empty);
  for (int i = 0; i < 2000; ++i) EXPECT_EQ(hand.next(kPeriod, Vec3(0)).position, start);
}

TEST(ExploringHand, BeginsAboveTheFirstStroke) {
  const auto plan = planOf({row(1, {0.3, 0.1, 0.02})}, 0.08);
  ExploringHand hand = following(plan);
  EXPECT_EQ(hand.next(0, Vec3(0)).position, Vec3(0.3, 0.1, 0.08));
}

TEST(ExploringHand, SparesAWeakDeviceAndALooseHand) {
  EXPECT_DOUBLE_EQ(ExploringHand(findHandPreset("light").value(), 3.3).targetForce_N(), 1);
  EXPECT_EQ(ExploringHand(nominal(), 3.3).targetForce_N(), 2);
  EXPECT_EQ(ExploringHand(nominal(), 12).targetForce_N(), 2);
  EXPECT_DOUBLE_EQ(ExploringHand(nominal(), 2.0).targetForce_N(), 1.2);
}

TEST(ExploringHand, PressesToItsTargetStrokesAndLifts) {
  const auto plan = planOf({row(1, Vec3(0))}, 0.06);
  ExploringHand hand = following(plan);
  Rubbing world;
  double force = 0, lowest = 1, highest = -1, farthest = 0;
  int pressing = 0;
  for (int i = 0; i < 12000; ++i) {
    const Vec3 p = world.tick(hand);
    lowest = std::min(lowest, p.z);
    if (i > 1000) highest = std::max(highest, p.z);
    farthest = std::max(farthest, p.x);
    if (world.force() > 1.5) force += world.force(), ++pressing;
    EXPECT_LT(world.force(), 2.4);
    EXPECT_EQ(p.y, 0);
  }
  EXPECT_NEAR(force / pressing, 2, 0.2);
  EXPECT_GT(pressing, 6000);
  EXPECT_NEAR(farthest, 0.04, 1e-9);
  EXPECT_NEAR(highest, 0.06, 1e-9);
}

TEST(ExploringHand, VisitsTheStrokesInTurnForEver) {
  const auto plan = planOf({row(1, {0, 0, 0}), row(2, {0.2, 0, 0}), row(7, {0, 0.2, 0}, 1)});
  ExploringHand hand = following(plan);
  Rubbing world;
  std::vector<int> visits;
  for (int i = 0; i < 40000; ++i) {
    const Vec3 p = world.tick(hand);
    const int at = p.y > 0.1 ? 2 : p.x > 0.1 ? 1 : 0;
    if (world.force() > 1 && (visits.empty() || visits.back() != at)) visits.push_back(at);
  }
  ASSERT_GE(visits.size(), 6U);
  for (std::size_t i = 0; i < visits.size(); ++i) EXPECT_EQ(visits[i], static_cast<int>(i % 3));
}

TEST(ExploringHand, GoesOnWhenItMeetsNothing) {
  const auto plan = planOf({row(1, {0, 0, 0}), row(2, {0.2, 0, 0})});
  ExploringHand hand = following(plan);
  std::vector<int> visits;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = hand.next(kPeriod, Vec3(0)).position;
    EXPECT_GE(p.z, -0.025);
    const int at = p.x > 0.1 ? 1 : 0;
    if (p.z < 0 && (visits.empty() || visits.back() != at)) visits.push_back(at);
  }
  EXPECT_GE(visits.size(), 4U);
}

/// Whether the hand goes on to the next stroke where the surface under it moves so far up.
bool leavesWhereTheSurfaceMoves(double up_m) {
  const auto plan = planOf({row(1, Vec3(0)), row(2, {0.2, 0, 0})});
  ExploringHand hand = following(plan);
  Rubbing world;
  runIntoStroke(hand, world, Vec3(0));
  world.moveGround(up_m);
  bool left = false;
  for (int i = 0; i < 3000 && !left; ++i) left = world.tick(hand).x > 0.15;
  return left;
}

TEST(ExploringHand, LiftsWhenTheSurfaceGoesAway) { EXPECT_TRUE(leavesWhereTheSurfaceMoves(-1)); }

TEST(ExploringHand, GivesWayToASurfaceThatRises) { EXPECT_TRUE(leavesWhereTheSurfaceMoves(0.05)); }

TEST(ExploringHand, GoesOnWithAStrokeThatANewPlanHoldsUnchanged) {
  auto plan = planOf({row(1, Vec3(0)), row(2, {0.2, 0, 0})});
  ExploringHand disturbed(nominal(), 3.3), undisturbed(nominal(), 3.3);
  const auto keep = planOf(plan->strokes);
  disturbed.follow(plan.get());
  undisturbed.follow(keep.get());
  Rubbing world, same;
  for (int i = 0; i < 20000; ++i) {
    if (i % 50 == 0) {
      // The object's place in the plan changes, and so do the others.
      auto next = planOf(i % 100 == 0 ? std::vector{row(1, Vec3(0)), row(2, {0.2, 0, 0})}
                                      : std::vector{row(1, Vec3(0)), row(2, {0.2, 0, 0}), row(3, {0, 0.5, 0})});
      if (i % 100 != 0) std::swap(next->strokes[1], next->strokes[2]), std::swap(next->strokes[0], next->strokes[1]);
      disturbed.follow(next.get());
      plan = std::move(next);  // the old one is gone
      disturbed.follow(planOf(keep->strokes).get());
      plan = planOf(keep->strokes);
      disturbed.follow(plan.get());
    }
    ASSERT_EQ(world.tick(disturbed), same.tick(undisturbed)) << i;
  }
}

TEST(ExploringHand, LiftsAndBeginsAnewWhenTheObjectUnderItChanged) {
  auto plan = planOf({row(1, {0.5, 0, 0}), row(2, Vec3(0)), row(3, {0, 0.5, 0})});
  ExploringHand hand = following(plan);
  Rubbing world;
  for (int i = 0; i < 20000 && !(world.force() > 1 && world.tick(hand).x < 0.05); ++i) world.tick(hand);
  plan = planOf({row(1, {0.5, 0, 0}), row(2, {0, 0.1, 0}), row(3, {0, 0.5, 0})});
  hand.follow(plan.get());
  double highest = 0;
  for (int i = 0; i < 6000; ++i) {
    const Vec3 p = world.tick(hand);
    highest = std::max(highest, p.z);
    if (i > 500 && world.force() > 0) {
      EXPECT_NEAR(p.y, 0.1, 1e-9);  // object 2 again, at its new place
      break;
    }
  }
  EXPECT_NEAR(highest, 0.1, 1e-9);
  EXPECT_GT(world.force(), 0);
}

/// Ticks until the hand presses at the given x.
void runUntilPressedAt(ExploringHand& hand, Rubbing& world, double x) {
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = world.tick(hand);
    if (world.force() > 1 && std::abs(p.x - x) < 0.05) return;
  }
  FAIL() << "the hand never pressed at x = " << x;
}

TEST(ExploringHand, GoesToTheNextObjectWhenTheOneUnderItIsRemoved) {
  auto plan = planOf({row(1, Vec3(0)), row(2, {0.2, 0, 0}), row(3, {0.4, 0, 0})});
  ExploringHand hand = following(plan);
  Rubbing world;
  runUntilPressedAt(hand, world, 0.2);
  plan = planOf({row(1, Vec3(0)), row(3, {0.4, 0, 0})});
  hand.follow(plan.get());
  Vec3 p(0);
  for (int i = 0; i < 6000 && !(i > 500 && world.force() > 0); ++i) p = world.tick(hand);
  EXPECT_NEAR(p.x, 0.4, 1e-9);
}

TEST(ExploringHand, GoesOnInTheOrderOfTheNewPlan) {
  auto plan = planOf({row(1, Vec3(0)), row(2, {0.2, 0, 0})});
  ExploringHand hand = following(plan);
  Rubbing world;
  runUntilPressedAt(hand, world, 0.2);
  plan = planOf({row(2, {0.2, 0, 0}), row(3, {0.4, 0, 0})});
  hand.follow(plan.get());
  Vec3 p(0);
  double highest = 0;
  for (int i = 0; i < 9000 && !(highest > 0.09 && world.force() > 0); ++i) {
    p = world.tick(hand);
    highest = std::max(highest, p.z);
  }
  EXPECT_NEAR(p.x, 0.4, 1e-9);
}

TEST(ExploringHand, LiftsAndWaitsWhenNothingIsLeftAndResumes) {
  auto plan = planOf({row(4, Vec3(0))});
  ExploringHand hand = following(plan);
  Rubbing world;
  runIntoStroke(hand, world, Vec3(0));
  hand.follow(nullptr);
  plan.reset();
  for (int i = 0; i < 3000; ++i) world.tick(hand);
  const Vec3 waiting = world.tick(hand);
  EXPECT_NEAR(waiting.z, 0.1, 1e-9);
  EXPECT_EQ(world.tick(hand), waiting);
  plan = planOf({row(1, {0, 0.3, 0})});
  hand.follow(plan.get());
  for (int i = 0; i < 6000 && world.force() == 0; ++i) world.tick(hand);
  EXPECT_NEAR(world.tick(hand).y, 0.3, 1e-9);
}

TEST(ExploringHand, ClearsAnObjectThatAppearsInItsWay) {
  auto plan = planOf({row(1, Vec3(0), 1), row(2, {0.4, 0, 0})}, 0.05);
  ExploringHand hand = following(plan);
  Rubbing world;
  Vec3 p(0);
  for (int i = 0; i < 20000 && p.x < 0.1; ++i) p = world.tick(hand);
  ASSERT_NEAR(p.z, 0.05, 1e-9);
  plan = planOf({row(1, Vec3(0), 1), row(2, {0.4, 0, 0}), row(3, {0.25, 0, 0.2})}, 0.25);
  hand.follow(plan.get());
  for (int i = 0; i < 3000 && p.x < 0.39; ++i) {
    p = world.tick(hand);
    EXPECT_TRUE(p.x < 0.2 || std::abs(p.z - 0.25) < 1e-9);
  }
  EXPECT_GT(p.x, 0.39);
}

TEST(ExploringHand, PushesFromBesideGoesBackAndLifts) {
  Stroke push = row(1, {0.2, 0, 0.03});
  push.isPush = true;
  const auto plan = planOf({push, row(2, {0, 0, 0})});
  ExploringHand hand = following(plan);
  double farthest = 0, lowest = 1;
  bool retreated = false;
  Vec3 last = hand.next(0, Vec3(0)).position;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p = hand.next(kPeriod, Vec3(0)).position;
    EXPECT_LT(glm::distance(p, last), 1e-3);
    last = p;
    if (p.x < 0.15) break;  // on to the next
    farthest = std::max(farthest, p.x);
    lowest = std::min(lowest, p.z);
    retreated = retreated || (farthest > 0.239 && p.x < 0.201 && p.z < 0.031);
  }
  EXPECT_NEAR(farthest, 0.24, 1e-6);
  EXPECT_NEAR(lowest, 0.03, 1e-6);
  EXPECT_TRUE(retreated);
}

TEST(ExploringHand, GivesUpAPushAgainstWhatStandsFast) {
  Stroke push = row(1, {0.2, 0, 0.03});
  push.isPush = true;
  const auto plan = planOf({push});
  ExploringHand hand = following(plan);
  double farthest = 0;
  for (int i = 0; i < 4000; ++i) {
    const double wall_N = 300 * std::max(0.0, farthest > 0 ? farthest - 0.21 : 0);
    farthest = std::max(farthest, hand.next(kPeriod, {-wall_N, 0, 0}).position.x);
  }
  EXPECT_GT(farthest, 0.21);
  EXPECT_LT(farthest, 0.225);
}

TEST(ExploringHand, NeverJumpsWhateverThePlansAndForcesAre) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> place(-0.3, 0.3), unit(0, 1);
  const double longestStep = 0.6 * kPeriod;  // metres; fastest: minimum jerk at a mean of 0.25 m/s
  for (int run = 0; run < 20; ++run) {
    ExploringHand hand(handPresets()[static_cast<std::size_t>(run) % handPresets().size()], 8);
    std::unique_ptr<ExplorationPlan> plan;
    Vec3 last = hand.next(0, Vec3(0)).position;
    for (int i = 0; i < 10000; ++i) {
      if (unit(engine) < 2e-3) {
        std::vector<Stroke> strokes;
        for (std::uint64_t id = 1; id < 6; ++id) {
          if (unit(engine) < 0.5) continue;
          strokes.push_back(
              row(id, {place(engine), place(engine), place(engine)}, 1 + static_cast<int>(60 * unit(engine))));
        }
        auto next = planOf(std::move(strokes), 0.4);
        hand.follow(unit(engine) < 0.1 ? nullptr : next.get());
        plan = std::move(next);
      }
      const double force = unit(engine) < 0.5 ? 0 : 8 * unit(engine);
      const Vec3 now = hand.next(kPeriod, {0, 0, force}).position;
      ASSERT_TRUE(isFinite(now));
      ASSERT_LE(glm::distance(now, last), longestStep) << run << ' ' << i;
      last = now;
    }
  }
}

}  // namespace
}  // namespace haptics::exploring_hand_test
