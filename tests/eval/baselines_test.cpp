// What the baselines are made of, each against something simpler.
#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "tests/eval/baselines/distance_field_shell.h"
#include "tests/eval/baselines/finite_proxy.h"
#include "tests/eval/baselines/global_closest.h"
#include "tests/eval/baselines/moeller_trumbore.h"
#include "tests/eval/baselines/spring_world.h"
#include "tests/eval/baselines/swept_sphere.h"
#include "tests/eval/corrections_off.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/random.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::baselines_test {
namespace {

Vec3 anywhere(Random& random) { return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}; }

TriangleRecord recordOf(const std::array<Vec3, 3>& corners) {
  shapes::Shape shape;
  for (const Vec3 v : corners) shape.vertices.emplace_back(v);
  shape.triangles = {{0, 1, 2}};
  return shape.build()->triangle(0);
}

TEST(SweptSphere, StopsWhereItFirstTouchesTheTriangle) {
  constexpr double kRadius = 0.3;
  Random random(1);
  int touched = 0;
  for (int i = 0; i < 5000; ++i) {
    const TriangleRecord record = recordOf({anywhere(random), anywhere(random), anywhere(random)});
    const std::array<Vec3, 3> corners{record.corner(0), record.corner(1), record.corner(2)};
    const auto gap = [&](Vec3 at) { return std::sqrt(closestOn(record, 0, at).squaredDistance) - kRadius; };
    const Vec3 from = anywhere(random) * 2.0;
    const Vec3 way = anywhere(random) * 3.0;
    if (gap(from) < 0) continue;
    const double time = SweptSphere(from, way, kRadius).firstTouch(corners, 1);
    for (int j = 0; j < 20; ++j) ASSERT_GT(gap(from + way * (time * j / 20)), -1e-9) << "not through it before";
    if (time < 1) {
      ++touched;
      ASSERT_NEAR(gap(from + way * time), 0, 1e-9);
    }
  }
  EXPECT_GT(touched, 100);
}

TEST(SweptSphere, SlidesAlongWhatItTouches) {
  const std::array<Vec3, 3> corners{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)};
  EXPECT_EQ(SweptSphere({-0.1, 0, 0.3}, {0.2, 0, 0}, 0.3).firstTouch(corners, 1), 1);
  EXPECT_EQ(SweptSphere({-0.1, 0, 0.3}, {0.2, 0, -0.1}, 0.3).firstTouch(corners, 1), 0);
}

TEST(FiniteProxy, FeelsASurfaceWhereItIsAndCannotEnterANarrowGap) {
  const auto comb = shapes::comb(2, 0.011, 0.01, 0.02, 0.02).build();  // a gap of 1 mm, half of what would pass
  const std::vector<std::shared_ptr<const CollisionMesh>> bodies{comb};
  const std::vector<Pose> poses(1);
  FiniteProxy proxy;
  proxy.begin(bodies, poses, {0.005, 0.001, 0.012});
  const Felt pressed = proxy.tick(poses, {0.005, 0.001, 0.008});
  EXPECT_NEAR(glm::distance(pressed.ihip, Vec3(0.005, 0.001, 0.01)), 0, 1e-9);
  EXPECT_NEAR(pressed.force_N.z, kSpring_N_per_m * 0.002, 1e-6);
  proxy.place({0, 0.001, 0.012});
  EXPECT_GT(proxy.tick(poses, {0, 0.001, 0.005}).force_N.z, kSpring_N_per_m * 0.004);
}

TEST(GlobalClosest, HasTheSpringOfAnEditUntilTheNextSceneBegins) {
  const std::vector<std::shared_ptr<const CollisionMesh>> box{shapes::box({0.1, 0.1, 0.1}).build()};
  const std::vector<Pose> poses(1);
  const Vec3 free(0, 0, 0.1), hip(0, 0, 0.049);
  GlobalClosest method;
  method.begin(box, poses, free);
  method.edit({{}, box, poses, 2000}, hip);
  EXPECT_NEAR(method.tick(poses, hip).force_N.z, 2, 1e-4);
  method.begin(box, poses, free);
  EXPECT_NEAR(method.tick(poses, hip).force_N.z, 1, 1e-4);
}

TEST(MoellerTrumbore, AgreesWithTheProductionTestAwayFromEdges) {
  Random random(2);
  int entered = 0;
  for (int i = 0; i < 20000; ++i) {
    const TriangleRecord record = recordOf({anywhere(random), anywhere(random), anywhere(random)});
    const Vec3 from = anywhere(random), to = anywhere(random);
    const bool twoSided = random.below(2) == 0;
    Crossing a, b;
    const bool enters = Segment(from, to).enters(record, twoSided, a);
    ASSERT_EQ(MoellerTrumbore(from, to).enters(record, twoSided, b), enters);
    if (!enters) continue;
    ++entered;
    ASSERT_NEAR(a.time, b.time, 1e-9);
    ASSERT_EQ(a.side, b.side);
  }
  EXPECT_GT(entered, 500);
}

TEST(InFloat, FindsTheClosestPointToWithinTheRoundingOfFloats) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const TriangleRecord record = recordOf({anywhere(random), anywhere(random), anywhere(random)});
    const double area = glm::length(record.areaNormal());
    if (area < 0.1) continue;  // rounding over a sliver moves the foot along it
    const Vec3 h = anywhere(random);
    const ClosestPoint inFloat = closestInFloat(record, 7, h);
    const ClosestPoint inDouble = closestOn(record, 7, h);
    ASSERT_LT(glm::distance(inFloat.point, inDouble.point), 1e-3);
    ASSERT_NEAR(inFloat.squaredDistance, inDouble.squaredDistance, 1e-5);
    ASSERT_EQ(inFloat.triangle, 7U);
  }
}

std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

TEST(DistanceField, IsTheDistanceFromASphereWithinAPartOfItsCell) {
  constexpr double kRadius_m = 0.05;
  const auto sphere = surfaceOf(makeSphere(kRadius_m, 64).value());
  const DistanceField field(*sphere, 64, 0.01);
  for (const double distance_m : {-0.02, -0.001, 0.001, 0.005}) {
    for (const Vec3 way : {Vec3(1, 0, 0), glm::normalize(Vec3(1, -2, 3)), glm::normalize(Vec3(-1, -1, 1))}) {
      const auto sample = field.at((kRadius_m + distance_m) * way);
      ASSERT_TRUE(sample);
      EXPECT_NEAR(sample->distance_m, distance_m, 0.1 * field.cell_m());
      EXPECT_GT(glm::dot(glm::normalize(sample->gradient), way), 0.995);
    }
  }
  EXPECT_FALSE(field.at(Vec3(0.07, 0, 0)));
  EXPECT_NEAR(field.distanceToGrid(Vec3(0.07, 0, 0)), 0.01, field.cell_m());
}

/// A ball of a tool that is led down onto a plate about z = 0, at 0.1 m/s: how low its lowest point comes, m.
double lowestOnPlate(double thickness_m, int cells) {
  const auto plate = surfaceOf(makeBox({0.1, 0.1, thickness_m}, 8).value());
  const auto ball = surfaceOf(makeSphere(0.01, 24).value());
  ToolShell shell = makeToolShell(*ball, 0.002).value();
  shell.points.resize(shell.spaced);
  const DistanceField field(*plate, cells, 0.01);
  DistanceFieldShell tool(shell, field, {800, 1});
  tool.reset({{1, 0, 0, 0}, {0, 0, 0.03}});
  double lowest_m = 1;
  for (int i = 0; i <= 250; ++i) {
    const Pose& pose = tool.follow({{1, 0, 0, 0}, {0, 0, 0.03 - 1e-4 * i}});
    for (const Vec3& point : shell.points) lowest_m = std::min(lowest_m, toWorld(pose, point).z);
  }
  return lowest_m;
}

TEST(DistanceFieldShell, SinksIntoAThickPlateAndPassesOneThatIsThinnerThanACell) {
  const double sunk_m = 0.01 - lowestOnPlate(0.02, 128);
  EXPECT_GT(sunk_m, 1e-4) << "springs give way";
  EXPECT_LT(sunk_m, 3e-3);
  EXPECT_LT(lowestOnPlate(0.0005, 128), -0.002);
}

constexpr double kBrick_kg = 0.1;

/// Springs between a table and a brick of 60 x 30 x 20 mm that stands on it, the hand far away.
class BrickOnSprings : public ::testing::Test {
 protected:
  SpringWorld world_;
  std::uint64_t brick_ = 0;

  void begin(Vec3 gravity_m_per_s2) {
    add({0.5, 0.5, 0.02}, {0, 0, -0.01}, false, Vec3(0));
    brick_ = add({0.06, 0.03, 0.02}, {0, 0, 0.01}, true, gravity_m_per_s2);
    world_.publish();
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) world_.tick({0, 0, 1});
  }
  [[nodiscard]] Vec3 velocity_m_per_s() const { return world_.stateOf(brick_).momentum_Ns / kBrick_kg; }

 private:
  std::uint64_t add(Vec3 size_m, Vec3 place, bool moves, Vec3 gravity_m_per_s2) {
    MovingSolid solid = solidFrom(makeBox(size_m, 1).value(), kBrick_kg);
    solid.body.gravity_m_per_s2 = gravity_m_per_s2;
    const std::uint64_t id = world_.add(solid, {{1, 0, 0, 0}, place}, moves);
    world_.object(id).collision = std::make_shared<const CollisionPoints>(makeCollisionPoints(*solid.surface));
    return id;
  }
};

TEST_F(BrickOnSprings, SinksUntilItsFourCornersBearItAndSleeps) {
  begin({0, 0, -9.81});
  run(2'000);
  const double sunk_m = kBrick_kg * 9.81 / (4 * springStiffness_N_per_m(kBrick_kg));
  EXPECT_NEAR(world_.poseOf(brick_).position.z, 0.01 - sunk_m, 1e-8);
  EXPECT_EQ(world_.stateOf(brick_).condition, BodyCondition::kAsleep);
}

TEST_F(BrickOnSprings, CreepsWithinTheConeOfFriction) {
  begin({1, 0, -9.81});
  run(500);
  const double begun_m = world_.poseOf(brick_).position.x;
  run(1'000);
  const double crept_m = world_.poseOf(brick_).position.x - begun_m;
  // Points of an edge may bear it beside the four corners.
  const double byOne_m = kBrick_kg / springDamping_Ns_per_m(kBrick_kg);
  EXPECT_LT(crept_m, byOne_m / 4 + 1e-6);
  EXPECT_GT(crept_m, byOne_m / kPointsOfPair);
}

TEST_F(BrickOnSprings, SlidesAgainstCoulombsFrictionBeyondIt) {
  begin({7, 0, -9.81});
  run(200);
  EXPECT_NEAR(velocity_m_per_s().x, 0.2 * (7 - 0.5 * 9.81), 0.01);
}

TEST_F(BrickOnSprings, IsPushedByTheOppositeOfWhatTheHandFeels) {
  begin(Vec3(0));
  Vec3 given_Ns(0);
  for (int i = 0; i < 20; ++i) given_Ns -= kPeriod_s * world_.tick({-0.029, 0.001, 0.01}).force.contact;
  EXPECT_GT(given_Ns.x, 0.005);
  EXPECT_NEAR(glm::distance(world_.stateOf(brick_).momentum_Ns, given_Ns), 0, 1e-12);
}

}  // namespace
}  // namespace haptics::eval::baselines_test
