#include "haptic_server/engine/collision/contact_solver.h"

#include <gmock/gmock.h>

#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::contact_solver_test {
namespace {

using testing::Gt;
using testing::Lt;

/// A box of 40 x 20 x 10 mm and 0.1 kg that falls straight down; its centre is the origin.
class FallingBox : public testing::Test {
 protected:
  FallingBox() : body_(boxOf({0.04, 0.02, 0.01}, 0.1)), state_(restingAt(body_, Pose{})) {
    state_.momentum_Ns = body_.mass.mass_kg * falling_m_per_s_;
    movers_ = {Mover(), mover()};
  }
  static Vec3 velocityAt(const Mover& mover, Vec3 place) {
    return mover.linear() + glm::cross(mover.angular(), place - mover.pivot());
  }
  /// No forces act on it.
  Mover mover() { return {body_, state_, {state_.momentum_Ns, state_.angularMomentum_Nms, 0}, kOne}; }

  static constexpr TickSteps kOne{1, 1e-3};
  const Vec3 falling_m_per_s_{0, 0, -0.1};
  const Vec3 edge_m_{0.02, 0, -0.005};
  RigidBody body_;
  RigidState state_;
  std::array<Mover, 2> movers_;  // the first one is the ground
};

TEST_F(FallingBox, SticksAtItsEdgeAfterOneRoundThoughPressingThereTurnsIt) {
  ContactSolver solver(movers_, kOne);
  ASSERT_TRUE(solver.add(1, 0, edge_m_, {0, 0, 1}, 0, 100, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  EXPECT_THAT(velocityAt(movers_[1], edge_m_).z, Gt(falling_m_per_s_.z));
  EXPECT_THAT(std::abs(velocityAt(movers_[1], edge_m_).x), Lt(1e-15));
}

TEST_F(FallingBox, HasTheImpulsesAndTheWayOnceItIsGiven) {
  ContactSolver solver(movers_, kOne);
  ASSERT_TRUE(solver.add(1, 0, edge_m_, {0, 0, 1}, 0, 100, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  const Vec3 before = state_.momentum_Ns;
  movers_[1].move();
  const Vec3 velocity = movers_[1].linear();
  movers_[1].give();
  const Vec3 impulse = solver.contact(0).impulse();
  EXPECT_THAT(glm::distance(state_.momentum_Ns, before + impulse), Lt(1e-15));
  EXPECT_THAT(glm::distance(state_.angularMomentum_Nms, glm::cross(edge_m_, impulse)), Lt(1e-15));
  EXPECT_THAT(glm::distance(state_.centre_m, 1e-3 * velocity), Lt(1e-15));
}

TEST_F(FallingBox, IsPulledByItsForcesInEqualParts) {
  const TickSteps two{2, 5e-4};
  const Momenta before{state_.momentum_Ns, state_.angularMomentum_Nms, 0};
  state_.momentum_Ns *= 2;
  Mover mover(body_, state_, before, two);
  mover.drive();
  EXPECT_THAT(glm::distance(mover.linear(), 1.5 * falling_m_per_s_), Lt(1e-15));
}

/// The box on the ground, and one of so many times its mass on it that falls, too.
class LoadedBox : public FallingBox {
 protected:
  LoadedBox() : load_(boxOf({0.04, 0.02, 0.01}, 300 * body_.mass.mass_kg)) {
    RigidState onTop = restingAt(load_, Pose{{1, 0, 0, 0}, {0, 0, 0.01}});
    onTop.momentum_Ns = load_.mass.mass_kg * falling_m_per_s_;
    loaded_ = {Mover(), mover(), Mover(load_, onTop, {onTop.momentum_Ns, Vec3(0), 0}, kOne)};
  }
  static void add(ContactSolver& solver) {
    ASSERT_TRUE(solver.add(1, 0, {0, 0, -0.005}, {0, 0, 1}, 0, 0, 0, Vec3(0)));
    ASSERT_TRUE(solver.add(2, 1, {0, 0, 0.005}, {0, 0, 1}, 0, 0, 0, Vec3(0)));
  }
  static void solve(ContactSolver& solver, int rounds, bool accelerated = true) {
    solver.beginRounds();
    for (int round = 0; round < rounds; ++round) {
      if (round > 0 && accelerated) solver.accelerate();
      static_cast<void>(solver.solve(false));
    }
  }

  RigidBody load_;
  std::array<Mover, 3> loaded_;
};

TEST_F(LoadedBox, IsHeldSoonerByAcceleratedRounds) {
  const auto leftAfter = [&](int rounds, bool accelerated) {
    std::array<Mover, 3> tried = loaded_;
    ContactSolver solver(tried, kOne);
    add(solver);
    solve(solver, rounds, accelerated);
    return std::abs(tried[2].linear().z / falling_m_per_s_.z);
  };
  EXPECT_GT(leftAfter(60, false), 0.8);
  EXPECT_LT(leftAfter(60, true), 0.1);
}

TEST_F(LoadedBox, IsNotHitAgainInTheStepAfterABlow) {
  ContactSolver solver(loaded_, kOne);
  add(solver);
  for (int step = 0; step < 2; ++step) {
    solver.warmStart();
    solve(solver, 60);
    solver.moved();
    EXPECT_LT(std::abs(loaded_[2].linear().z / falling_m_per_s_.z), 0.1) << step;
  }
}

TEST_F(FallingBox, IsSlowedByFrictionNoMoreThanThePressingAllows) {
  state_.momentum_Ns += Vec3(0.01, 0, 0);
  movers_[1] = mover();
  ContactSolver solver(movers_, kOne);
  ASSERT_TRUE(solver.add(1, 0, {0, 0, -0.005}, {0, 0, 1}, 0, 0.3, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  const Vec3 impulse = solver.contact(0).impulse();
  EXPECT_NEAR(impulse.x, -0.3 * impulse.z, 1e-15);
  EXPECT_NEAR(impulse.y, 0, 1e-15);
}

}  // namespace
}  // namespace haptics::test::contact_solver_test
