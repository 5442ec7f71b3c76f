#include "haptic_server/engine/tool/tool_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "tests/haptic_server/engine/tool/held_among.h"

namespace haptics::tool_contact_test {
namespace {

constexpr ToolCoupling kCoupling{.stiffness_N_per_m = 1000, .torsion_Nm_per_rad = 2};

Quat about(Vec3 axis, double angle_rad) { return glm::angleAxis(angle_rad, glm::normalize(axis)); }

/// A slab whose top is z = 0.
struct Ground {
  std::shared_ptr<const CollisionMesh> surface = surfaceOf(makeBox({0.4, 0.4, 0.1}, 4).value());
  std::vector<Body> bodies{bodyOf(surface, {{1, 0, 0, 0}, {0, 0, -0.05}})};
};

/// From `from` to `to` at 0.1 m/s and 1 rad/s, then at rest: the last tick.
ToolResult bring(ToolContact& tool, const std::vector<Body>& bodies, const Pose& from, const Pose& to,
                 const ToolCoupling& coupling = kCoupling) {
  tool.reset(from, bodies);
  constexpr int kTicks = 500;
  ToolResult result;
  for (int i = 1; i <= kTicks + 100; ++i)
    result = tool.follow(bodies, interpolate(from, to, std::min(1.0, static_cast<double>(i) / kTicks)), coupling);
  return result;
}

/// How far two poses are from each other, as the springs measure it: the square is twice their energy, J.
double stretch(const Pose& a, const Pose& b, const ToolCoupling& coupling = kCoupling) {
  return std::sqrt(coupling.stiffness_N_per_m * squaredLength(a.position - b.position) +
                   coupling.torsion_Nm_per_rad *
                       squaredLength(rotationVector(a.rotation * glm::conjugate(b.rotation))));
}

/// A tool that hangs on what rests stretches its springs by no more than the few skins by which planes lift it.
constexpr double kMaxGain = 1e-6;

/// How deep the deepest point of the tool is in a closed surface, m; 0: none is inside.
double deepest(const HeldAmong& tool, const Body& body) {
  double depth = 0;
  for (const Vec3& point : tool.tool().shell.points) {
    const Vec3 at = body.frame.toLocal(toWorld(tool.proxy(), point));
    int looked = 0;
    const ClosestPoint foot = body.surface->closestFoot(at, 1 << 20, looked);
    if (!body.surface->isOutside(foot, at)) depth = std::max(depth, std::sqrt(foot.squaredDistance));
  }
  return depth;
}

TEST(ToolContact, GoesWithItsDeviceWhereNothingIs) {
  const Ground ground;
  HeldAmong tool(makeSphere(0.02, 8).value(), 0.004, ground.bodies);
  const Pose to{about({1, 2, 3}, 0.5), {0.02, 0.01, 0.1}};
  const ToolResult result = bring(tool, ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.2}}, to);
  EXPECT_NEAR(glm::distance(result.proxy.position, to.position), 0, 1e-12);
  EXPECT_NEAR(glm::length(result.force_N) + glm::length(result.torque_Nm), 0, 1e-9);
  EXPECT_EQ(tool.touching(), 0);
}

TEST(ToolContact, BoxRestsOnAFace) {
  const Ground ground;
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005, ground.bodies);
  const ToolResult result = bring(tool, ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, {{1, 0, 0, 0}, {0.01, 0, 0.003}});
  EXPECT_NEAR(result.proxy.position.z, 0.005, 1e-6);
  EXPECT_NEAR(result.force_N.z, 2, 0.002);
  EXPECT_NEAR(glm::length(result.torque_Nm), 0, 1e-5);
  EXPECT_GE(tool.touching(), 4);
}

TEST(ToolContact, TiltedDeviceIsTurnedBackByAFaceUntilItLifts) {
  const Ground ground;
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005, ground.bodies);
  // Pressed with 3 N, a lever of 20 mm holds the face down against torques up to 0.06 Nm.
  const ToolResult flat =
      bring(tool, ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, {about({0, 1, 0}, 0.02), {0, 0, 0.002}});
  EXPECT_NEAR(flat.force_N.z, 3, 0.003);
  EXPECT_NEAR(flat.torque_Nm.y, -0.04, 1e-4);
  EXPECT_GE(tool.touching(), 4);
  const ToolResult lifted =
      bring(tool, ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, {about({0, 1, 0}, 0.1), {0, 0, 0.002}});
  EXPECT_NEAR(std::abs(lifted.torque_Nm.y), 0.02 * lifted.force_N.z, 0.02 * 0.02 * lifted.force_N.z);  // about the edge
  EXPECT_GE(tool.touching(), 2);
  EXPECT_LT(tool.touching(), 6);
}

TEST(ToolContact, BoxRestsOnAnEdgeAndOnACorner) {
  const Ground ground;
  const TriMesh box = makeBox({0.02, 0.02, 0.02}, 2).value();
  HeldAmong tool(box, 0.004, ground.bodies);
  const Quat onEdge = about({1, 0, 0}, std::acos(-1) / 4);
  const ToolResult edge =
      bring(tool, ground.bodies, {onEdge, {0, 0, 0.03}}, {onEdge, {0, 0, 0.01 * std::sqrt(2) - 0.002}});
  EXPECT_NEAR(edge.force_N.z, 2, 0.002);
  EXPECT_NEAR(glm::length(edge.torque_Nm), 0, 1e-4);
  const Quat onCorner = about({1, -1, 0}, std::acos(1 / std::sqrt(3)));
  const ToolResult corner =
      bring(tool, ground.bodies, {onCorner, {0, 0, 0.03}}, {onCorner, {0, 0, 0.01 * std::sqrt(3) - 0.002}});
  EXPECT_NEAR(corner.force_N.z, 2, 0.002);
  EXPECT_NEAR(glm::length(corner.torque_Nm), 0, 1e-4);
}

/// Of a shape's surface, world.
struct Place {
  Vec3 at, normal;
};

/// A ball that is pressed 4 mm into a shape along its normal with 0.4 N, at each place: what the formula of a ball says. The
/// force is as far off as a gap between points is deep, the torque as the force times a lever of half a gap.
void expectBallIsFeltExactly(const std::shared_ptr<const CollisionMesh>& surface, const std::vector<Place>& places) {
  constexpr double kRadius_m = 0.005, kDepth_m = 0.004;
  constexpr ToolCoupling kSoft{.stiffness_N_per_m = 100, .torsion_Nm_per_rad = 1};
  const std::vector<Body> bodies{bodyOf(surface)};
  HeldAmong ball(makeSphere(kRadius_m, 64).value(), 0.00016, bodies);
  double force = 0, torque_Nm = 0;
  for (const Place& place : places) {
    const Quat turned = about({1, 2, 3}, 10 * place.at.x + place.at.y);
    const ToolResult felt = bring(ball, bodies, {turned, place.at + (kRadius_m + 0.001) * place.normal},
                                  {turned, place.at + (kRadius_m - kDepth_m) * place.normal}, kSoft);
    const Vec3 exact_N = kSoft.stiffness_N_per_m * kDepth_m * place.normal;
    force = std::max(force, std::abs(glm::length(felt.force_N) / glm::length(exact_N) - 1));
    torque_Nm = std::max(torque_Nm, glm::length(felt.torque_Nm));
  }
  std::printf("%zu points, %zu places: force %.4f %% off, torque %.2e Nm\n", ball.tool().shell.points.size(),
              places.size(), 100 * force, torque_Nm);
  EXPECT_LE(force, 1e-3);
  EXPECT_LE(torque_Nm, 1e-4);
}

TEST(ToolContact, BallIsFeltOnPlaneSphereCylinderAndTorusAsItsFormulaSays) {
  constexpr double kPi = std::numbers::pi;
  expectBallIsFeltExactly(
      surfaceOf(makeBox({0.4, 0.4, 0.1}, 4).value()),
      {{{0.01, 0.02, 0.05}, {0, 0, 1}}, {{-0.03, 0.01, 0.05}, {0, 0, 1}}, {{0.2, 0, 0.01}, {1, 0, 0}}});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Place> sphere, cylinder, torus;
  for (int i = 0; i < 8; ++i) {
    const Vec3 n = glm::normalize(Vec3(any(random), any(random), any(random)));
    sphere.push_back({0.03 * n, n});
    const double u = kPi * any(random), v = kPi * any(random);
    const Vec3 out(std::cos(u), std::sin(u), 0);
    cylinder.push_back({0.02 * out + Vec3(0, 0, 0.02 * any(random)), out});
    const Vec3 normal = std::cos(v) * out + Vec3(0, 0, std::sin(v));
    torus.push_back({0.05 * out + 0.02 * normal, normal});
  }
  expectBallIsFeltExactly(surfaceOf(makeSphere(0.03, 128).value()), sphere);
  expectBallIsFeltExactly(surfaceOf(makeCylinder(0.02, 0.1, 512).value()), cylinder);
  expectBallIsFeltExactly(surfaceOf(makeTorus(0.05, 0.02, 1024, 512).value()), torus);
}

/// Joules that a tool gives the hand on the second time round a closed way, moved and turned.
double givenRoundALoop_J(const TriMesh& mesh, double spacing_m, const std::vector<Body>& bodies, Vec3 middle) {
  HeldAmong tool(mesh, spacing_m, bodies);
  constexpr int kTicks = 4000;
  const auto poseAt = [&](int i) {
    const double angle = 2 * std::numbers::pi * i / kTicks;
    return Pose{about({1, 0, 0}, 0.1 * std::sin(angle)) * about({0, 0, 1}, 0.3 * std::cos(2 * angle)),
                middle + Vec3(0.012 * std::cos(angle), 0.012 * std::sin(angle), 0.001 * std::sin(3 * angle))};
  };
  Pose before = poseAt(0);
  tool.reset({before.rotation, before.position + Vec3(0, 0, 0.03)}, bodies);
  ToolResult last;
  for (int i = 0; i < 300; ++i)
    last =
        tool.follow(bodies, {before.rotation, before.position + Vec3(0, 0, std::max(0.0, 0.03 - 1e-4 * i))}, kCoupling);
  double given_J = 0;
  for (int i = 1; i <= 2 * kTicks; ++i) {
    const Pose now = poseAt(i);
    const ToolResult felt = tool.follow(bodies, now, kCoupling);
    if (i > kTicks) {
      given_J += glm::dot(0.5 * (felt.force_N + last.force_N), now.position - before.position) +
                 glm::dot(0.5 * (felt.torque_Nm + last.torque_Nm),
                          rotationVector(now.rotation * glm::conjugate(before.rotation)));
    }
    before = now;
    last = felt;
  }
  EXPECT_GT(glm::length(last.force_N), 0.3);
  return given_J;
}

TEST(ToolContact, GivesNoEnergyRoundClosedLoops) {
  const Ground ground;
  const auto torus = surfaceOf(makeTorus(0.05, 0.02, 256, 128).value());
  const TriMesh bar = makeBox({0.04, 0.02, 0.01}, 2).value(), ball = makeSphere(0.01, 32).value();
  const std::vector<Body> ring{bodyOf(torus)};
  const double loops_J[] = {givenRoundALoop_J(bar, 0.004, ground.bodies, {0, 0, 0.003}),
                            givenRoundALoop_J(ball, 0.0005, ground.bodies, {0, 0, 0.007}),
                            givenRoundALoop_J(bar, 0.002, ring, {0.05, 0, 0.022}),
                            givenRoundALoop_J(ball, 0.0005, ring, {0.05, 0, 0.027})};
  for (const double given_J : loops_J) {
    std::printf("%.2f uJ\n", 1e6 * given_J);
    EXPECT_LE(given_J, 10e-6);
    EXPECT_GE(given_J, -1.5e-3) << "over curved surfaces the proxy comes a little late, which takes some";
  }
}

TEST(ToolContact, IsTurnedByWhatTouchesItBesideItsMiddle) {
  const Ground ground;
  HeldAmong tool(makeBox({0.1, 0.004, 0.004}, 2).value(), 0.004, ground.bodies);
  // Held at one end: the frame's origin is the device's.
  const Quat tilted = about({0, 1, 0}, 0.3);
  const ToolResult result = bring(tool, ground.bodies, {tilted, {0, 0, 0.05}}, {tilted, {0, 0, 0.01}});
  EXPECT_GT(result.force_N.z, 0.1);
  EXPECT_GT(std::abs(result.torque_Nm.y), 0.8 * 0.05 * result.force_N.z * std::cos(0.3));
  EXPECT_LT(deepest(tool, ground.bodies[0]), 1e-12);
}

TEST(ToolContact, IsHeldByWhatItsTorsionAsksHoweverFarItIsTwisted) {
  const auto wall = surfaceOf(makeBox({0.2, 0.2, 0.1}, 4).value());
  const std::vector<Body> slot{bodyOf(wall, {{1, 0, 0, 0}, {0, 0, -0.0552}}),
                               bodyOf(wall, {{1, 0, 0, 0}, {0, 0, 0.0552}})};
  for (const double twist_rad : {0.2, 0.8, 1.4}) {
    HeldAmong tool(makeBox({0.06, 0.02, 0.01}, 2).value(), 0.005, slot);
    const ToolResult result = bring(tool, slot, {}, {about({0, 1, 0}, twist_rad), {0.001, 0, 0}});
    EXPECT_NEAR(result.torque_Nm.y, -kCoupling.torsion_Nm_per_rad * twist_rad, 0.03) << "a clearance of 0.4 mm";
    Vec3 held_Nm(0), held_N(0);
    for (const ToolPoint& point : std::span(result.held).first(result.heldCount)) {
      held_N += point.force_N;
      held_Nm += glm::cross(point.place - result.proxy.position, point.force_N);
    }
    EXPECT_NEAR(glm::distance(held_N, result.force_N), 0, 0.01) << twist_rad;
    EXPECT_NEAR(glm::distance(held_Nm, result.torque_Nm), 0, 0.003) << twist_rad;
  }
}

TEST(ToolContact, NeverPassesAThinPlateHoweverFast) {
  const auto plate = surfaceOf(makeBox({0.4, 0.4, 0.0005}, 8).value());
  const std::vector<Body> bodies{bodyOf(plate)};
  HeldAmong tool(makeSphere(0.02, 24).value(), 0.0018, bodies);
  ASSERT_GE(tool.tool().shell.points.size(), 900U);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int seed = 0; seed < 20; ++seed) {
    const Vec3 axis(unit(random), unit(random), unit(random));
    const Vec3 sideways = 0.5 * Vec3(unit(random), unit(random), 0);
    tool.reset({{1, 0, 0, 0}, {0, 0, 0.05}}, bodies);
    for (int i = 1; i <= 50; ++i) {  // 2 m/s, 20 rad/s
      const double t = 1e-3 * i;
      const ToolResult result =
          tool.follow(bodies, {about(axis, 20 * t), Vec3(0, 0, 0.05 - 2 * t) + sideways * t}, kCoupling);
      for (const Vec3& point : tool.tool().shell.points)
        ASSERT_GT(toWorld(result.proxy, point).z, 0.00025) << "seed " << seed << ", tick " << i;
    }
    EXPECT_NEAR(tool.proxy().position.z, 0.02025, 0.001);
  }
}

TEST(ToolContact, IsNeverInsideOfATorusInARandomWalk) {
  const auto torus = surfaceOf(makeTorus(0.04, 0.015, 96, 48).value());
  const std::vector<Body> bodies{bodyOf(torus)};
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  HeldAmong tool(makeBox({0.03, 0.01, 0.01}, 2).value(), 0.002, bodies);
  Pose device{{1, 0, 0, 0}, {0.04, 0, 0.03}};
  tool.reset(device, bodies);
  Vec3 velocity(0), spin(0), before(0);
  int waits = 0, touching = 0;
  double jump = 0;
  for (int i = 0; i < 20'000; ++i) {
    velocity += 0.02 * Vec3(normal(random), normal(random), normal(random)) - 0.01 * velocity -
                0.1 * (device.position - Vec3(0.04, 0, 0));
    spin += 0.4 * Vec3(normal(random), normal(random), normal(random)) - 0.01 * spin;
    device.position += 1e-3 * velocity;
    device.rotation = glm::normalize(
        glm::angleAxis(1e-3 * glm::length(spin) + 1e-12, glm::normalize(spin + Vec3(1e-9))) * device.rotation);
    const Pose proxyBefore = tool.proxy();
    const ToolResult result = tool.follow(bodies, device, kCoupling);
    ASSERT_LT(stretch(result.proxy, device), stretch(proxyBefore, device) + kMaxGain) << "tick " << i;
    waits += result.waits ? 1 : 0;
    touching += tool.touching() > 0 ? 1 : 0;
    jump = std::max(jump, glm::distance(result.force_N, before));
    before = result.force_N;
    if (i % 10 == 0) {
      ASSERT_LT(deepest(tool, bodies[0]), 1e-9) << "tick " << i;
    }
  }
  EXPECT_GT(touching, 5'000);
  std::printf("%d of 20000 touch, %d wait, largest change of force %.3f N\n", touching, waits, jump);
}

/// A sphere with bumps and a roughness that makes most of its vertices sharp.
TriMesh roughBall(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  TriMesh ball = makeSphere(0.04, 24).value();
  for (Vec3f& v : ball.vertices) {
    const Vec3 d = glm::normalize(Vec3(v));
    const double bump = 0.004 * std::sin(40 * d.x) * std::sin(37 * d.y) * std::sin(31 * d.z);
    v = Vec3f(d * (0.04 + bump + 0.0004 * unit(random)));
  }
  return ball;
}

/// A torus in a shaking hand, against a ball that is at rest, or goes to and fro, turns, and is put elsewhere at times.
void feelRoughBall(bool moves) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto kick = [&] {  // one by one: compilers differ in the order of arguments
    const double z = normal(random), y = normal(random), x = normal(random);
    return Vec3(x, y, z);
  };
  const auto ball = surfaceOf(roughBall(random));
  std::vector<Body> bodies{bodyOf(ball)};
  const auto torus = surfaceOf(makeTorus(0.014, 0.005, 32, 16).value());
  HeldAmong tool(makeTorus(0.014, 0.005, 32, 16).value(), 0.0015, bodies);
  ASSERT_GT(tool.sharp(0).size(), 500U);
  Pose device{{1, 0, 0, 0}, {0, 0, 0.07}};
  tool.reset(device, bodies);
  Vec3 velocity(0), spin(0);
  int waits = 0, touching = 0, stuck = 0, longestStuck = 0;
  double way = 0;
  for (int i = 0; i < 4'000; ++i) {
    if (moves) {
      const double t = 1e-3 * i;
      bodies[0].current = {about({1, 2, 3}, 0.5 * std::sin(3 * t)),
                           0.004 * Vec3(std::sin(9 * t), i / 50 % 2, std::sin(7 * t))};
      bodies[0].update();
    }
    const Vec3 to = 0.042 * glm::normalize(device.position);
    velocity += 0.02 * kick() - 0.01 * velocity - 0.1 * (device.position - to);
    spin += 0.6 * kick() - 0.01 * spin;
    device.position += 1e-3 * velocity;
    device.rotation = glm::normalize(about(spin + Vec3(1e-9), 1e-3 * glm::length(spin)) * device.rotation);
    const ToolPose before = tool.proxy();  // a hand does not get farther from it than this
    const double far = glm::distance(device.position, before.position);
    device = interpolate(before, device, std::min(1.0, 0.008 / far));
    const ToolResult result = tool.follow(bodies, device, kCoupling, Allowance(140'000));
    ASSERT_GT(result.allowance.left(), -8 * Allowance::kQuery) << i;
    if (!moves) {
      ASSERT_LT(stretch(result.proxy, device), stretch(before, device) + kMaxGain) << i;
    }
    stuck = way > 0 && result.waits && result.proxy == before ? stuck + 1 : 0;
    longestStuck = std::max(longestStuck, stuck);
    waits += result.waits ? 1 : 0;
    touching += tool.touching() > 0 ? 1 : 0;
    way += glm::distance(before.position, result.proxy.position);
    if (i % 20 != 0) continue;
    const Pose& tested = tool.testedAt(0);
    ASSERT_LT(deepest(tool, bodyOf(ball, tested)), 1e-12) << i;
    for (const Vec3& corner : tool.sharp(0)) {
      const Vec3 at = toLocal(tool.proxy(), toWorld(tested, corner));
      int looked = 0;
      const ClosestPoint foot = torus->closestFoot(at, 1 << 20, looked);
      ASSERT_TRUE(torus->isOutside(foot, at) || foot.squaredDistance < 1e-24) << i;
    }
  }
  EXPECT_GT(waits, 1'000);
  EXPECT_GT(touching, 1'000);
  EXPECT_GT(way, 0.3);
  if (!moves) {
    EXPECT_LT(longestStuck, 5) << "once how far everything is has been asked for all points";
  }
}

TEST(ToolContact, IsOutsideOfARoughBallAndTheBallOfItWhileItsAllowanceIsTooSmall) { feelRoughBall(false); }

TEST(ToolContact, IsOutsideOfABallThatComesToItWhileItsAllowanceIsTooSmall) { feelRoughBall(true); }

TEST(ToolContact, GoesOnWhereATicksAllowanceIsTooSmallForAllPointsThatTouch) {
  const auto plate = surfaceOf(makeBox({0.2, 0.2, 0.02}, 40).value());  // its top at z = 0
  const std::vector<Body> bodies{bodyOf(plate, {{1, 0, 0, 0}, {0, 0, -0.01}})};
  HeldAmong tool(makeBox({0.05, 0.014, 0.014}, 2).value(), 0.00145, bodies);
  Pose device{{1, 0, 0, 0}, {0, 0, 0.0071}};
  tool.reset(device, bodies);
  device.position.z = 0.005;
  (void)tool.follow(bodies, device, kCoupling);
  ASSERT_GT(tool.touching(), 50);
  double farthest = 0;
  for (int i = 0; i < 2'000; ++i) {
    device.position.x = 1e-5 * std::min(i, 1'000);
    const ToolResult result = tool.follow(bodies, device, kCoupling, Allowance(80'000));
    ASSERT_GT(result.proxy.position.z, 0.007) << i;
    farthest = std::max(farthest, device.position.x - result.proxy.position.x);
  }
  EXPECT_LT(farthest, 0.001);
  EXPECT_NEAR(tool.proxy().position.x, 0.01, 1e-6);
}

TEST(ToolContact, StretchesNoSpringByItselfWhereItsDeviceIsTurnedFarFromIt) {
  constexpr ToolCoupling kSoft{.stiffness_N_per_m = 800, .torsion_Nm_per_rad = 0.5};
  constexpr double kFarthest_m = 0.008, kFarthest_rad = 1, kMaxTurn_rad = 0.7;
  for (const std::uint64_t seed : {2, 3}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0, 1);
    const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    const auto ball = surfaceOf(roughBall(random));
    const std::vector<Body> bodies{bodyOf(ball)};
    HeldAmong tool(makeBox({0.05, 0.014, 0.014}, 2).value(), 0.0025, bodies);
    Pose device{{1, 0, 0, 0}, {0, 0, 0.07}};
    tool.reset(device, bodies);
    Vec3 velocity(0);
    Quat goal = device.rotation;
    double speed_rad_per_s = 1;
    for (int i = 0; i < 6'000; ++i) {
      const Pose before = tool.proxy();
      const Vec3 to = 0.042 * glm::normalize(device.position);
      velocity += 0.02 * vector() - 0.01 * velocity - 0.1 * (device.position - to);
      device.position += 1e-3 * velocity;
      const Vec3 away = device.position - before.position;
      device.position = before.position + away * std::min(1.0, kFarthest_m / glm::length(away));
      const Vec3 left = rotationVector(goal * glm::conjugate(device.rotation));
      const Vec3 twist = rotationVector(device.rotation * glm::conjugate(before.rotation));
      if (glm::length(left) < 2e-3 * speed_rad_per_s || glm::length(twist) > kFarthest_rad) {
        goal = glm::normalize(about(vector(), kMaxTurn_rad * unit(random)) * before.rotation);
        speed_rad_per_s = 0.1 * std::pow(100.0, unit(random));
      } else {
        device.rotation = glm::normalize(about(left, 1e-3 * speed_rad_per_s) * device.rotation);
      }
      const ToolResult result = tool.follow(bodies, device, kSoft);
      ASSERT_LT(stretch(result.proxy, device, kSoft), stretch(before, device, kSoft) + 1e-4) << seed << ", tick " << i;
    }
  }
}

TEST(ToolContact, RestsOnABladeBetweenItsPoints) {
  const auto blade = surfaceOf(makeBox({0.2, 0.0004, 0.04}, 1).value());  // its edge up, at z = 0
  const std::vector<Body> bodies{bodyOf(blade, {{1, 0, 0, 0}, {0, 0.0025, -0.02}})};
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005, bodies);
  const ToolResult result = bring(tool, bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, {{1, 0, 0, 0}, {0, 0, 0.004}});
  EXPECT_NEAR(result.force_N.z, 1, 0.2);  // it hangs over to the side
  EXPECT_NEAR(result.torque_Nm.x, 0.0025 * result.force_N.z, 0.0003);
  // Sideways over its edge: never through it.
  for (int i = 1; i <= 300; ++i) {
    (void)tool.follow(bodies, {{1, 0, 0, 0}, {0, 1e-4 * i, 0.004}}, kCoupling);
    for (const Vec3& corner : tool.sharp(0)) {
      const Vec3 at = toLocal(tool.proxy(), bodies[0].frame.toWorld(corner));
      const Vec3 within = Vec3(0.02, 0.01, 0.005) - glm::abs(at);
      ASSERT_LT(std::min({within.x, within.y, within.z}), 1e-9) << i;
    }
  }
}

TEST(ToolContact, RestsOnANeedleBetweenItsPoints) {
  const auto needle = surfaceOf(makeBox({0.0004, 0.0004, 0.04}, 1).value());
  const std::vector<Body> bodies{bodyOf(needle, {{1, 0, 0, 0}, {0.0121, 0.0023, -0.02}})};
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005, bodies);
  const ToolCoupling stiff{.stiffness_N_per_m = 1000, .torsion_Nm_per_rad = 100};
  const ToolResult result = bring(tool, bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, {{1, 0, 0, 0}, {0, 0, 0.003}}, stiff);
  EXPECT_NEAR(result.force_N.z, 2, 0.02);
  EXPECT_NEAR(result.torque_Nm.y, -0.0121 * result.force_N.z, 0.001);
  EXPECT_GE(tool.touching(), 1);
}

TEST(ToolContact, LooksAtNothingThatTheLastTickFoundInTheWay) {
  const auto needle = surfaceOf(makeBox({0.0004, 0.0004, 0.04}, 1).value());
  const auto floor = surfaceOf(makeBox({0.1, 0.1, 0.01}, 1).value());
  const std::vector<Body> bodies{bodyOf(needle, {{1, 0, 0, 0}, {0.0121, 0.0023, -0.02}}),
                                 bodyOf(floor, {{1, 0, 0, 0}, {0, 0, -0.05}})};
  const Tool box = toolOf(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005);
  const auto memory = std::make_unique<ToolMemory>();
  const auto scratch = std::make_unique<ToolScratch>();
  ToolContact tool(*memory, *scratch);
  tool.hold(box);
  const auto sharp = sharpPoints(*needle, 0.005, kMaxToolPoints);
  const std::array obstacles{ToolContact::Obstacle{bodies[0].current, sharp, -1},
                             ToolContact::Obstacle{bodies[1].current, {}, -1}};
  tool.adopt(obstacles);
  const Pose device{{1, 0, 0, 0}, {0, 0, 0.003}};
  const Vec3 before_N = bring(tool, bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, device).force_N;
  ASSERT_GE(tool.touching(), 1);
  ToolTouch stale = memory->touches[0];
  stale.ofBody = 0;
  stale.body = 1;
  stale.triangle = 1U << 30U;  // of what an edit has taken away
  scratch->hits.fill(stale);
  scratch->hitCount = scratch->hits.size();
  EXPECT_LT(glm::distance(tool.follow(bodies, device, kCoupling).force_N, before_N), 0.01);
}

TEST(ToolContact, ForgetsSharpPointsOfABodyThatAreOthersNow) {
  const auto needle = surfaceOf(makeBox({0.0004, 0.0004, 0.04}, 1).value());
  const std::vector<Body> bodies{bodyOf(needle, {{1, 0, 0, 0}, {0.0121, 0.0023, -0.02}})};
  const Tool box = toolOf(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005);
  const auto memory = std::make_unique<ToolMemory>();
  ToolScratch scratch;
  ToolContact tool(*memory, scratch);
  tool.hold(box);
  const auto sharp = sharpPoints(*needle, 0.005, kMaxToolPoints);
  tool.adopt(std::array{ToolContact::Obstacle{bodies[0].current, sharp, -1}});
  const Pose device{{1, 0, 0, 0}, {0, 0, 0.003}};
  const Vec3 before_N = bring(tool, bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, device).force_N;
  const auto ofNeedle = [&] { return std::ranges::count(memory->touches.all(), 1, &ToolTouch::ofBody); };
  ASSERT_GE(ofNeedle(), 1);
  const auto again = sharp;  // the same ones elsewhere in memory
  tool.adopt(std::array{ToolContact::Obstacle{bodies[0].current, again, 0}});
  EXPECT_GE(ofNeedle(), 1);
  const std::vector<Vec3> fewer(sharp.begin() + 1, sharp.end());  // as of a tool whose points are farther apart
  tool.adopt(std::array{ToolContact::Obstacle{bodies[0].current, fewer, 0}});
  EXPECT_EQ(ofNeedle(), 0);
  EXPECT_LT(glm::distance(tool.follow(bodies, device, kCoupling).force_N, before_N), 0.01);
}

TEST(ToolContact, IsLetOutOfABodyThatAnEditPutsAroundItAndMeetsItThen) {
  const auto plate = surfaceOf(makeBox({0.1, 0.1, 0.008}, 4).value());
  const std::vector<Body> bodies{bodyOf(plate)};
  HeldAmong tool(makeBox({0.01, 0.01, 0.06}, 3).value(), 0.002, {});
  tool.reset({}, {});
  tool.adopt(std::array{ToolContact::Obstacle{bodies[0].current, {}, -1}});
  const auto go = [&](double from_m, double to_m, double& largest_N) {
    ToolResult result;
    for (int i = 1; i <= 500; ++i) {
      const Pose device{{1, 0, 0, 0}, {0.002 * std::sin(0.05 * i), 0, from_m + (to_m - from_m) * i / 500}};
      result = tool.follow(bodies, device, kCoupling, Allowance(400'000));
      largest_N = std::max(largest_N, glm::length(result.force_N));
    }
    return result;
  };
  double around_N = 0, again_N = 0;
  go(0, -0.01, around_N);
  go(-0.01, 0.05, around_N);
  EXPECT_LT(around_N, 1e-9);
  const ToolResult result = go(0.05, 0.03, again_N);
  EXPECT_NEAR(result.proxy.position.z, 0.034, 1e-5);
  EXPECT_NEAR(result.force_N.z, 4, 0.02);
}

TEST(ToolContact, StaysOnASurfaceThatAnEditMakesAnew) {
  const Ground ground;
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.005, ground.bodies);
  const Pose device{{1, 0, 0, 0}, {0, 0, 0.003}};
  bring(tool, ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.02}}, device);
  TriMesh finer = makeBox({0.4, 0.4, 0.1}, 5).value();
  std::mt19937 random(1);
  for (Vec3f& vertex : finer.vertices) vertex.z += std::uniform_real_distribution<float>(-3e-4F, 3e-4F)(random);
  const auto surface = surfaceOf(finer);
  const std::vector<Body> bodies{bodyOf(surface, ground.bodies[0].current)};
  tool.adopt(std::array{ToolContact::Obstacle{bodies[0].current, {}, -1}});
  for (int i = 0; i < 200; ++i)
    EXPECT_GT(tool.follow(bodies, device, kCoupling).proxy.position.z, 0.0045) << "at the device it would be at 3 mm";
}

TEST(ToolContact, IsPushedByABodyThatMoves) {
  const auto wall = surfaceOf(makeBox({0.1, 0.1, 0.1}, 4).value());
  std::vector<Body> bodies{bodyOf(wall, {{1, 0, 0, 0}, {0, 0, -0.08}})};
  HeldAmong tool(makeSphere(0.02, 16).value(), 0.003, bodies);
  const Pose device{};
  tool.reset(device, bodies);
  ToolResult result;
  for (int i = 1; i <= 300; ++i) {
    bodies[0].previous = bodies[0].current;
    bodies[0].current.position.z += 1e-4;  // 0.1 m/s, 30 mm in all
    bodies[0].update();
    result = tool.follow(bodies, device, kCoupling);
    ASSERT_LT(deepest(tool, bodies[0]), 1e-9) << i;
  }
  EXPECT_NEAR(result.proxy.position.z, 0.02, 0.001);
  EXPECT_NEAR(result.force_N.z, 20, 1);
}

TEST(ToolContact, PaysNothingForABodyThatMovesFarAwayAndMeetsItWhenItComes) {
  const auto ball = surfaceOf(makeSphere(0.03, 16).value());
  const Ground ground;
  std::vector<Body> bodies{ground.bodies[0], bodyOf(ball, {{1, 0, 0, 0}, {0.6, 0, 0.005}})};
  HeldAmong tool(makeBox({0.04, 0.02, 0.01}, 2).value(), 0.002, bodies);
  const Pose device{{1, 0, 0, 0}, {0, 0, 0.003}};
  tool.reset({{1, 0, 0, 0}, {0, 0, 0.0051}}, bodies);
  constexpr std::int64_t kAllowance = 250'000;
  ToolResult result;
  std::int64_t dearest = 0;
  for (int i = 1; i <= 600; ++i) {
    bodies[1].previous = bodies[1].current;
    bodies[1].current.position.x += (i <= 400 ? i % 40 < 20 : false) ? 0.005 : -0.005;  // 5 m/s, to and fro, then here
    bodies[1].update();
    result = tool.follow(bodies, device, kCoupling, Allowance(kAllowance));
    if (i > 100 && i <= 400) dearest = std::max(dearest, kAllowance - result.allowance.left());
    for (const Body& body : {ground.bodies[0], bodies[1]}) {
      // A ball that has come too far for a tick is met where the tool has been tested against it.
      Body tested = body;
      tested.current = tool.testedAt(body.surface == ball.get() ? 1 : 0);
      tested.update();
      ASSERT_LT(deepest(tool, tested), 1e-9) << i;
    }
  }
  EXPECT_LT(dearest, kAllowance / 10);
  EXPECT_LT(result.proxy.position.x, -0.004) << "the ball pushes it along, as fast as the allowance lasts";
}

TEST(ToolContact, EndsATickWhoseAllowanceIsSpentAtAClearPlace) {
  const Ground ground;
  HeldAmong tool(makeSphere(0.02, 24).value(), 0.0022, ground.bodies);
  tool.reset({{1, 0, 0, 0}, {0, 0, 0.05}}, ground.bodies);
  ToolResult result;
  int waits = 0;
  for (int i = 1; i <= 200; ++i) {
    result = tool.follow(ground.bodies, {{1, 0, 0, 0}, {0, 0, 0.05 - 2e-4 * i}}, kCoupling, Allowance(100'000));
    waits += result.waits ? 1 : 0;
    ASSERT_LT(deepest(tool, ground.bodies[0]), 1e-12);
  }
  EXPECT_GT(waits, 0);
}

}  // namespace
}  // namespace haptics::tool_contact_test
