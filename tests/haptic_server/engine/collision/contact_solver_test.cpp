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
    movers_[1] = Mover(body_, state_, 1e-3);
  }

  const Vec3 falling_m_per_s_{0, 0, -0.1};
  const Vec3 edge_m_{0.02, 0, -0.005};
  RigidBody body_;
  RigidState state_;
  std::array<Mover, 2> movers_;  // the first one is the ground
};

TEST_F(FallingBox, SticksAtItsEdgeAfterOneRoundThoughPressingThereTurnsIt) {
  ContactSolver solver(movers_, 1e-3);
  ASSERT_TRUE(solver.add(1, 0, edge_m_, {0, 0, 1}, 0, 100, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  EXPECT_THAT(movers_[1].velocityAt(edge_m_).z, Gt(falling_m_per_s_.z));
  EXPECT_THAT(std::abs(movers_[1].velocityAt(edge_m_).x), Lt(1e-15));
}

TEST_F(FallingBox, GetsTheImpulsesOnceTheyAreGivenAndOnlyOnce) {
  ContactSolver solver(movers_, 1e-3);
  ASSERT_TRUE(solver.add(1, 0, edge_m_, {0, 0, 1}, 0, 100, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  const Vec3 before = state_.momentum_Ns;
  for (int i = 0; i < 2; ++i) movers_[1].give();
  const Vec3 impulse = solver.contact(0).impulse();
  EXPECT_THAT(glm::distance(state_.momentum_Ns, before + impulse), Lt(1e-15));
  EXPECT_THAT(glm::distance(state_.angularMomentum_Nms, glm::cross(edge_m_, impulse)), Lt(1e-15));
}

TEST_F(FallingBox, IsSlowedByFrictionNoMoreThanThePressingAllows) {
  state_.momentum_Ns += Vec3(0.01, 0, 0);
  movers_[1] = Mover(body_, state_, 1e-3);
  ContactSolver solver(movers_, 1e-3);
  ASSERT_TRUE(solver.add(1, 0, {0, 0, -0.005}, {0, 0, 1}, 0, 0.3, 0, Vec3(0)));
  static_cast<void>(solver.solve(false));
  const Vec3 impulse = solver.contact(0).impulse();
  EXPECT_NEAR(impulse.x, -0.3 * impulse.z, 1e-15);
  EXPECT_NEAR(impulse.y, 0, 1e-15);
}

}  // namespace
}  // namespace haptics::test::contact_solver_test
