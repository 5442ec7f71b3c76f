#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "tests/haptic_server/engine/tool/held_among.h"

namespace haptics::jaws_test {
namespace {

constexpr ToolCoupling kCoupling{.stiffness_N_per_m = 600, .torsion_Nm_per_rad = 1, .grip_Nm_per_rad = 0.2};
constexpr double kGap_m = 1e-4;  // of either jaw from the plane between them
constexpr JawHinge kHinge{{0, 0, 0}, {0, -1, 0}, {1, 0, 0}};

/// Two bars of 40 x 8 x 4 mm, one on the other, from 2 mm before the hinge on.
TriMesh jaws(JawHinge hinge = kHinge) {
  TriMesh both = makeBox({0.04, 0.008, 0.004}, 4).value();
  const TriMesh bar = both;
  const auto count = static_cast<std::uint32_t>(bar.vertices.size());
  for (Vec3f& v : both.vertices) v += Vec3f(hinge.place_m + Vec3(0.022, 0, 0.002 + kGap_m));
  for (const Vec3f& v : bar.vertices)
    both.vertices.push_back(v + Vec3f(hinge.place_m + Vec3(0.022, 0, -0.002 - kGap_m)));
  for (const TriangleIndices& t : bar.triangles) both.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  return both;
}

class Held : public HeldAmong {
 public:
  using HeldAmong::HeldAmong;

  /// World, of a jaw: 1 the upper, -1 the lower one.
  [[nodiscard]] Pose jaw(int side) const {
    const Vec3 hinge = tool().jaws->hinge_m;
    const Quat opened = glm::angleAxis(0.5 * side * proxy().opening_rad, tool().jaws->axis);
    return {proxy().rotation * opened, toWorld(proxy(), hinge - opened * hinge)};
  }
  /// How deep the deepest point of the tool is in a closed surface, m; 0: none is inside.
  [[nodiscard]] double deepestIn(const Body& body) const {
    double depth = 0;
    for (std::size_t i = 0; i < tool().shell.points.size(); ++i) {
      const Pose pose = jaw(i < tool().jaws->firstOfLower ? 1 : -1);
      const Vec3 at = body.frame.toLocal(toWorld(pose, tool().shell.points[i]));
      int looked = 0;
      const ClosestPoint foot = body.surface->closestFoot(at, 1 << 20, looked);
      if (!body.surface->isOutside(foot, at)) depth = std::max(depth, std::sqrt(foot.squaredDistance));
    }
    return depth;
  }
};

Tool makeTool(double spacing_m, JawHinge hinge = kHinge) {
  const TriMesh mesh = jaws(hinge);
  return makeJaws(mesh.vertices, mesh.triangles, hinge, spacing_m).value();
}

/// J.
double energy(const ToolPose& proxy, const ToolPose& device) {
  const double opened = proxy.opening_rad - device.opening_rad;
  return 0.5 * (kCoupling.stiffness_N_per_m * squaredLength(proxy.position - device.position) +
                kCoupling.torsion_Nm_per_rad *
                    squaredLength(rotationVector(proxy.rotation * glm::conjugate(device.rotation))) +
                kCoupling.grip_Nm_per_rad * opened * opened);
}

/// Force, torque and moment of the points that hold a tool are those that the hand feels.
void expectBalanced(const Held& tool, const ToolResult& felt, double tolerance) {
  Vec3 force_N(0), torque_Nm(0);
  double grip_Nm = 0;
  const Vec3 axis = felt.proxy.rotation * tool.tool().jaws->axis;
  const Vec3 hinge = toWorld(felt.proxy, tool.tool().jaws->hinge_m);
  for (const ToolPoint& held : std::span(felt.held).first(felt.heldCount)) {
    force_N += held.force_N;
    torque_Nm += glm::cross(held.place - felt.proxy.position, held.force_N);
    const double above = glm::dot(felt.proxy.rotation * Vec3(0, 0, 1), held.place - hinge);
    const bool isInside = std::abs(above) < 0.007;  // of what is between the jaws: it pushes them apart
    ASSERT_TRUE(isInside);
    grip_Nm += (above > 0 ? 0.5 : -0.5) * glm::dot(axis, glm::cross(held.place - hinge, held.force_N));
  }
  EXPECT_NEAR(glm::distance(force_N, felt.force_N), 0, 600 * tolerance);
  EXPECT_NEAR(glm::distance(torque_Nm, felt.torque_Nm), 0, tolerance);
  EXPECT_NEAR(grip_Nm, felt.grip_Nm, tolerance);
}

TEST(Jaws, AreTheTwoSidesOfAMesh) {
  const Tool tool = makeTool(0.002);
  EXPECT_EQ(tool.surface->triangleCount(), tool.jaws->lower->triangleCount());
  EXPECT_GT(tool.jaws->firstOfLower, 100U);
  for (std::size_t i = 0; i < tool.shell.points.size(); ++i)
    EXPECT_EQ(tool.shell.points[i].z > 0, i < tool.jaws->firstOfLower);
  EXPECT_GE(tool.shell.radius_m, 0.042);
}

TEST(Jaws, AreRefusedWhereTheyAreOneOrOnOneSide) {
  const TriMesh box = makeBox({0.04, 0.01, 0.01}, 1).value(), both = jaws();
  const auto reasonOf = [](const TriMesh& mesh, const JawHinge& hinge) {
    const auto made = makeJaws(mesh.vertices, mesh.triangles, hinge, 0.002);
    return made ? std::string() : made.error().reason;
  };
  EXPECT_NE(reasonOf(box, kHinge).find("are joined by a triangle"), std::string::npos);
  EXPECT_NE(reasonOf(both, {{0, 0, -0.1}, kHinge.axis, kHinge.reach}).find("on one side"), std::string::npos);
  EXPECT_NE(reasonOf(both, {{0, 0, kGap_m}, kHinge.axis, kHinge.reach}).find("leave a gap"), std::string::npos);
  EXPECT_EQ(makeJaws(both.vertices, both.triangles, kHinge, 1e-4).error().field, "spacing_m");
}

TEST(Jaws, OpenAsTheirDeviceDoesWhereNothingIsBetween) {
  const JawHinge aside{{0.01, 0.02, -0.03}, kHinge.axis, kHinge.reach};
  const auto ball = surfaceOf(makeSphere(0.005, 16).value());
  const std::vector<Body> bodies{bodyOf(ball, {{1, 0, 0, 0}, {0.5, 0, 0}})};
  Held tool(makeTool(0.002, aside), 0.002, bodies);
  tool.reset({}, bodies);
  const Pose at{glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, 3))), {0.01, 0.02, 0.03}};
  ToolResult felt;
  for (int i = 0; i < 10; ++i) felt = tool.follow(bodies, {at, 0.5}, kCoupling);
  EXPECT_NEAR(felt.proxy.opening_rad, 0.5, 1e-12);
  EXPECT_NEAR(glm::length(felt.force_N) + glm::length(felt.torque_Nm) + std::abs(felt.grip_Nm), 0, 1e-9);
  EXPECT_FALSE(felt.waits);
}

/// What two jaws that close feel of what is fixed between them.
struct Closed {
  ToolResult felt;
  double firstTouch_rad = 0;
  double work_J = 0, energy_J = 0;  ///< What the hand gave to the gripper, and what the springs have.
  double largestError_Nm = 0, largestChange_Nm = 0;
};

constexpr double kStep_rad = 5e-4, kReach_m = 0.032;

Closed close(Held& tool, const std::vector<Body>& bodies) {
  Closed closed;
  tool.reset({Pose{}, 0.6}, bodies);
  ToolResult last;
  for (int i = 0; i <= 1200; ++i) {
    const ToolPose device{Pose{}, std::max(0.0, 0.6 - kStep_rad * i)};
    const ToolResult felt = tool.follow(bodies, device, kCoupling);
    if (i % 20 == 0) {
      EXPECT_LT(tool.deepestIn(bodies[0]), 1e-9) << i;
    }
    const double energy_J = energy(felt.proxy, device), mean_Nm = 0.5 * (felt.grip_Nm + last.grip_Nm);
    if (i > 0) {
      const double byEnergy_Nm = (energy_J - closed.energy_J) / kStep_rad;  // M = -dE/dalpha
      closed.largestError_Nm = std::max(closed.largestError_Nm, std::abs(mean_Nm - byEnergy_Nm));
      closed.work_J += mean_Nm * kStep_rad;
      closed.largestChange_Nm = std::max(closed.largestChange_Nm, std::abs(felt.grip_Nm - last.grip_Nm));
    }
    if (closed.firstTouch_rad == 0 && felt.grip_Nm > 1e-5) closed.firstTouch_rad = device.opening_rad;
    last = felt;
    closed.energy_J = energy_J;
  }
  for (int i = 0; i < 50; ++i) closed.felt = tool.follow(bodies, {Pose{}, 0}, kCoupling);
  return closed;
}

TEST(Jaws, GiveTheHandTheMomentByWhichTheirEnergyChanges) {
  const auto block = surfaceOf(makeBox({0.006, 0.02, 0.008}, 1).value());
  for (const double off_m : {0.0, 0.002}) {
    const std::vector<Body> bodies{bodyOf(block, {{1, 0, 0, 0}, {kReach_m, 0, off_m}})};
    Held tool(makeTool(0.001), 0.001, bodies);
    const Closed closed = close(tool, bodies);
    EXPECT_LT(closed.largestError_Nm, 1e-4) << off_m;
    EXPECT_NEAR(closed.work_J, closed.energy_J, 1e-6) << off_m;
    EXPECT_GT(closed.felt.grip_Nm, 0.03) << off_m;
    EXPECT_LT(closed.largestChange_Nm, 2e-4) << "a step of the device is 1e-4 Nm";
    expectBalanced(tool, closed.felt, 1e-4);
  }
}

TEST(Jaws, FeelABallInTheirMiddleAlike) {
  constexpr double kRadius_m = 0.005;
  const auto ball = surfaceOf(makeSphere(kRadius_m, 32).value());
  const std::vector<Body> bodies{bodyOf(ball, {{1, 0, 0, 0}, {kReach_m, 0, 0}})};
  Held tool(makeTool(0.001), 0.001, bodies);
  const Closed closed = close(tool, bodies);
  EXPECT_NEAR(closed.firstTouch_rad, 2 * std::asin((kRadius_m - kGap_m) / kReach_m), 0.01);
  EXPECT_NEAR(closed.felt.force_N.z, 0, 0.02);
  EXPECT_NEAR(closed.felt.torque_Nm.y, 0, 1e-3);
  EXPECT_LT(closed.felt.force_N.x, -0.1) << "the jaws are a wedge, and the ball drives it back";
  const Vec3 up = toLocal(tool.jaw(1), {kReach_m, 0, 0}), down = toLocal(tool.jaw(-1), {kReach_m, 0, 0});
  EXPECT_NEAR(-up.z, down.z, 1e-4);
  expectBalanced(tool, closed.felt, 1e-4);
  EXPECT_LE(closed.energy_J, closed.work_J);
  EXPECT_NEAR(closed.energy_J, closed.work_J, 0.01 * closed.work_J) << "points that come to hold it take a little";
}

TEST(Jaws, AreMovedToABallOffTheirMiddle) {
  const auto ball = surfaceOf(makeSphere(0.005, 32).value());
  const std::vector<Body> bodies{bodyOf(ball, {{1, 0, 0, 0}, {kReach_m, 0, 0.002}})};
  Held tool(makeTool(0.001), 0.001, bodies);
  const Closed closed = close(tool, bodies);
  EXPECT_GT(closed.felt.force_N.z, 0.1);
  EXPECT_LT(closed.felt.torque_Nm.y, -1e-3);
  expectBalanced(tool, closed.felt, 1e-4);
}

/// With its jaws held fast a tool is a rigid one of the same points.
TEST(Jaws, OfWhichOneTouchesAreARigidToolWhereTheirSpringIsStiff) {
  const auto slab = surfaceOf(makeBox({0.4, 0.4, 0.1}, 4).value());
  const std::vector<Body> bodies{bodyOf(slab, {{1, 0, 0, 0}, {0, 0, -0.05}})};
  constexpr double kOpening_rad = 0.3;
  Held opened(makeTool(0.002), 0.002, bodies);
  Tool fast{opened.tool().surface, opened.tool().shell};
  for (std::size_t i = 0; i < fast.shell.points.size(); ++i) {
    const double side = i < opened.tool().jaws->firstOfLower ? 0.5 : -0.5;
    fast.shell.points[i] = glm::angleAxis(side * kOpening_rad, kHinge.axis) * fast.shell.points[i];
  }
  Held rigid(fast, 0.002, bodies);
  ToolCoupling stiff = kCoupling;
  stiff.grip_Nm_per_rad = 1e5;
  const Pose above{{1, 0, 0, 0}, {0, 0, 0.03}};
  opened.reset({above, kOpening_rad}, bodies);
  rigid.reset(above, bodies);
  ToolResult felt, asRigid;
  for (int i = 0; i < 600; ++i) {
    const Pose device{glm::angleAxis(0.0002 * i, Vec3(1, 0, 0)), {1e-5 * i, 0, 0.03 - 0.03 * std::min(1.0, i / 400.0)}};
    felt = opened.follow(bodies, {device, kOpening_rad}, stiff);
    asRigid = rigid.follow(bodies, device, stiff);
    ASSERT_NEAR(glm::distance(felt.force_N, asRigid.force_N), 0, 1e-3) << i;
    ASSERT_NEAR(glm::distance(felt.torque_Nm, asRigid.torque_Nm), 0, 1e-4) << i;
  }
  EXPECT_GT(felt.force_N.z, 1);
}

TEST(Jaws, AreNoFurtherClosedThanClosed) {
  const auto slab = surfaceOf(makeBox({0.4, 0.4, 0.1}, 4).value());
  const std::vector<Body> bodies{bodyOf(slab, {{1, 0, 0, 0}, {0, 0, -0.05}})};
  Held tool(makeTool(0.002), 0.002, bodies);
  Held rigid(Tool{tool.tool().surface, tool.tool().shell}, 0.002, bodies);
  tool.reset({{1, 0, 0, 0}, {0, 0, 0.02}}, bodies);
  rigid.reset({{1, 0, 0, 0}, {0, 0, 0.02}}, bodies);
  ToolResult felt;
  for (int i = 0; i < 400; ++i) {
    const Pose device{glm::angleAxis(2e-4 * i, Vec3(0, 1, 0)), {0, 0, 0.02 - 5e-5 * i}};
    felt = tool.follow(bodies, device, kCoupling);
    const ToolResult asRigid = rigid.follow(bodies, device, kCoupling);
    ASSERT_GE(felt.proxy.opening_rad, 0) << i;
    ASSERT_NEAR(glm::distance(felt.force_N, asRigid.force_N), 0, 1e-6) << i;
    ASSERT_NEAR(glm::distance(felt.torque_Nm, asRigid.torque_Nm), 0, 1e-7) << i;
  }
  EXPECT_GT(felt.force_N.z, 1) << "the floor under the lower jaw";
  EXPECT_NEAR(felt.proxy.opening_rad, 0, 1e-9);
  EXPECT_NEAR(felt.grip_Nm, 0, 1e-9) << "their stop holds them, not the hand";
}

TEST(Jaws, CloseOnARodBetweenTheirPoints) {
  const auto rod = surfaceOf(makeBox({0.0012, 0.04, 0.0012}, 1).value());
  const std::vector<Body> bodies{bodyOf(rod, {{1, 0, 0, 0}, {0.0317, 0, 0}})};
  Held tool(makeTool(0.006), 0.006, bodies);
  tool.reset({Pose{}, 0.3}, bodies);
  ToolResult felt;
  for (int i = 0; i <= 700; ++i) felt = tool.follow(bodies, {Pose{}, std::max(0.0, 0.3 - 5e-4 * i)}, kCoupling);
  EXPECT_GT(felt.grip_Nm, 0.004);
  for (const Vec3& corner : sharpPoints(*rod, 0.006, kMaxToolPoints)) {
    for (const int side : {1, -1}) {
      const Vec3 at =
          toLocal(tool.jaw(side), bodies[0].frame.toWorld(corner)) - Vec3(0.022, 0, side * (0.002 + kGap_m));
      const Vec3 within = Vec3(0.02, 0.004, 0.002) - glm::abs(at);
      EXPECT_LT(std::min({within.x, within.y, within.z}), 1e-9);
    }
  }
}

/// Whatever the hand does with its wrist and fingers.
TEST(Jaws, AreNeverInsideOfATorusInARandomWalk) {
  const auto torus = surfaceOf(makeTorus(0.03, 0.006, 64, 32).value());
  const std::vector<Body> bodies{bodyOf(torus)};
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const double spacing_m = 0.002;
  Held tool(makeTool(spacing_m), spacing_m, bodies);
  ToolPose device{Pose{{1, 0, 0, 0}, {-0.02, 0, 0.05}}, 0.3};
  tool.reset(device, bodies);
  Vec3 velocity(0), spin(0);
  double opening = 0, pinched = 0;
  int touching = 0, waits = 0;
  for (int i = 0; i < 10'000; ++i) {
    velocity += 0.02 * Vec3(normal(random), normal(random), normal(random)) - 0.01 * velocity -
                0.1 * (device.position - Vec3(0, 0, 0));
    spin += 0.4 * Vec3(normal(random), normal(random), normal(random)) - 0.01 * spin;
    opening += 0.3 * normal(random) - 0.02 * opening - 0.5 * (device.opening_rad - 0.25);
    device.position += 1e-3 * velocity;
    device.rotation = glm::normalize(rotationBy(1e-3 * spin) * device.rotation);
    device.opening_rad = std::clamp(device.opening_rad + 1e-3 * opening, 0.0, 0.55);
    const double before = energy(tool.proxy(), device);
    const ToolResult felt = tool.follow(bodies, device, kCoupling);
    ASSERT_LT(std::sqrt(2 * energy(felt.proxy, device)), std::sqrt(2 * before) + 1e-6) << "tick " << i;
    ASSERT_GE(felt.proxy.opening_rad, 0);
    waits += felt.waits ? 1 : 0;
    touching += tool.touching() > 0 ? 1 : 0;
    pinched = std::max(pinched, felt.grip_Nm);
    if (i % 10 == 0) {
      ASSERT_LT(tool.deepestIn(bodies[0]), 1e-9) << "tick " << i;
    }
  }
  EXPECT_GT(touching, 2'000);
  EXPECT_GT(pinched, 0.01);
  std::printf("touching in %d ticks, %d wait, pinched with up to %.3f Nm\n", touching, waits, pinched);
}

}  // namespace
}  // namespace haptics::jaws_test
