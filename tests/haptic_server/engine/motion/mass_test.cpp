#include <gtest/gtest.h>

#include <random>

#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::mass_test {
namespace {

Solid solid(const TriMesh& mesh) { return solidOf(mesh.vertices, mesh.triangles); }

/// Largest element's difference over the largest element.
double apart(const glm::dmat3& a, const glm::dmat3& b) {
  double difference = 0;
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      difference = std::max(difference, std::abs(a[i][k] - b[i][k]));
      largest = std::max(largest, std::abs(b[i][k]));
    }
  }
  return difference / largest;
}

glm::dmat3 diagonal(double x, double y, double z) { return {{x, 0, 0}, {0, y, 0}, {0, 0, z}}; }

TEST(Solid, OfABoxIsExact) {
  const Solid s = solid(makeBox({0.125, 0.25, 0.5}, 3).value());
  ASSERT_EQ(s.defect, SolidDefect::kNone);
  const double volume = 0.125 * 0.25 * 0.5;
  EXPECT_NEAR(s.volume_m3, volume, 1e-7 * volume);
  EXPECT_LT(glm::length(s.centre), 1e-8);
  const double twelfth = volume / 12;
  EXPECT_LT(
      apart(s.inertia, diagonal(twelfth * (0.0625 + 0.25), twelfth * (0.015625 + 0.25), twelfth * (0.015625 + 0.0625))),
      1e-7);
}

TEST(Solid, OfASphereAndATorusComesNearTheAnalyticAsTheSquareOfTheirFacets) {
  const double r = 0.05;
  const double sphereVolume = 4 * kPi * r * r * r / 3;
  const double R = 0.06;
  const double a = 0.02;
  const double torusVolume = 2 * kPi * kPi * R * a * a;
  const double across = 0.5 * R * R + 5 * a * a / 8;
  const glm::dmat3 sphere = sphereVolume * 0.4 * r * r * glm::dmat3(1);
  const glm::dmat3 torus = torusVolume * diagonal(across, across, R * R + 0.75 * a * a);
  double sphereBefore = 0;
  double torusBefore = 0;
  for (const std::uint32_t n : {16U, 32U, 64U}) {
    // An angle of 2 phi between facets takes (1 - cos phi) off the radius: 5 phi^2 / 2 off the inertia, at worst.
    const double phi = kPi / n / 2;
    const Solid ball = solid(makeSphere(r, n).value());
    const double ballError = apart(ball.inertia, sphere);
    EXPECT_LT(ballError, 5 * 2 * phi * phi);
    const Solid ring = solid(makeTorus(R, a, 2 * n, n).value());
    const double ringError = apart(ring.inertia, torus);
    EXPECT_LT(ringError, 5 * 2 * (2 * phi) * (2 * phi));
    if (sphereBefore > 0) {
      EXPECT_NEAR(sphereBefore / ballError, 4, 0.2);
      EXPECT_NEAR(torusBefore / ringError, 4, 0.2);
    }
    sphereBefore = ballError;
    torusBefore = ringError;
    EXPECT_LT(glm::length(ball.centre) + glm::length(ring.centre), 1e-8);
  }
}

TEST(Solid, FollowsTheMeshWhenItIsTurnedAndMoved) {
  const TriMesh mesh = makeBox({0.03, 0.05, 0.08}, 2).value();
  const Solid still = solid(mesh);
  const Pose pose{glm::normalize(Quat(0.3, 0.5, -0.2, 0.7)), {0.5, -0.3, 0.2}};
  TriMesh moved = mesh;
  for (Vec3f& v : moved.vertices) v = Vec3f(toWorld(pose, Vec3(v)));
  const Solid after = solid(moved);
  EXPECT_LT(glm::distance(after.centre, pose.position), 1e-7);
  const glm::dmat3 turn = glm::mat3_cast(pose.rotation);
  EXPECT_LT(apart(after.inertia, turn * still.inertia * glm::transpose(turn)), 1e-5);
}

TEST(Solid, CountsAHoleOut) {
  TriMesh shell = makeBox({0.1, 0.1, 0.1}, 1).value();
  const TriMesh hole = makeBox({0.05, 0.05, 0.05}, 1).value();
  const auto first = static_cast<std::uint32_t>(shell.vertices.size());
  shell.vertices.insert(shell.vertices.end(), hole.vertices.begin(), hole.vertices.end());
  for (const auto& t : hole.triangles) shell.triangles.push_back({first + t[0], first + t[2], first + t[1]});
  const Solid s = solid(shell);
  EXPECT_EQ(s.defect, SolidDefect::kNone);
  EXPECT_NEAR(s.volume_m3, 0.875e-3, 1e-9);
}

TEST(Solid, IsRefusedOfAnOpenAnInsideOutAndAFlatMesh) {
  TriMesh open = makeSphere(0.05, 8).value();
  open.triangles.pop_back();
  EXPECT_EQ(solid(open).defect, SolidDefect::kOpen);
  EXPECT_EQ(solid(open).openSides, 3U);

  TriMesh insideOut = makeSphere(0.05, 8).value();
  for (auto& t : insideOut.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(solid(insideOut).defect, SolidDefect::kInsideOut);

  TriMesh oneFlipped = makeSphere(0.05, 8).value();
  std::swap(oneFlipped.triangles[0][1], oneFlipped.triangles[0][2]);
  EXPECT_EQ(solid(oneFlipped).defect, SolidDefect::kOpen);

  const TriMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  EXPECT_EQ(solid(flat).defect, SolidDefect::kFlat);
}

TEST(SpreadMass, FindsTheAxesOfAnyInertia) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Quat turn = glm::normalize(Quat(normal(random), normal(random), normal(random), normal(random)));
    const double x = std::abs(normal(random)) + 0.01;
    const double y = i % 3 == 0 ? x : std::abs(normal(random)) + 0.01;  // round ones too
    const double z = i % 6 == 0 ? x : 0.999 * (x + y - std::abs(x - y)) / 2 + std::abs(x - y);
    const glm::dmat3 axes = glm::mat3_cast(turn);
    const glm::dmat3 inertia = axes * diagonal(x, y, z) * glm::transpose(axes);
    MassProperties mass;
    ASSERT_EQ(spreadMass(2, {0, 0, 0}, inertia, mass), MassDefect::kNone) << i;
    const glm::dmat3 found = glm::mat3_cast(mass.principal);
    EXPECT_LT(apart(found * diagonal(mass.moments.x, mass.moments.y, mass.moments.z) * glm::transpose(found), inertia),
              1e-12)
        << i;
  }
}

TEST(SpreadMass, RefusesWhatNoBodyHas) {
  MassProperties mass;
  const glm::dmat3 good = diagonal(1, 1, 1);
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(spreadMass(bad, Vec3(0), good, mass), MassDefect::kMass);
  }
  EXPECT_EQ(spreadMass(1, {0, std::nan(""), 0}, good, mass), MassDefect::kCentre);
  EXPECT_EQ(spreadMass(1, Vec3(0), diagonal(1, 0, 1), mass), MassDefect::kInertia);
  EXPECT_EQ(spreadMass(1, Vec3(0), diagonal(1, -1, 1), mass), MassDefect::kInertia);
  EXPECT_EQ(spreadMass(1, Vec3(0), diagonal(1, std::nan(""), 1), mass), MassDefect::kInertia);
  glm::dmat3 skew = good;
  skew[0][1] = 0.1;
  EXPECT_EQ(spreadMass(1, Vec3(0), skew, mass), MassDefect::kInertia);
  EXPECT_EQ(spreadMass(1, Vec3(0), diagonal(1, 1, 2.1), mass), MassDefect::kBeyond);
  EXPECT_EQ(spreadMass(1, Vec3(0), diagonal(1, 1, 2), mass), MassDefect::kNone) << "a flat disc";
}

TEST(SupportPoints, OfABoxAreItsCornersHoweverFineItsMesh) {
  const auto points = supportPoints(makeBox({0.1, 0.2, 0.003}, 20).value().vertices);
  EXPECT_EQ(points.size(), 8U);
  for (const Vec3 p : points) EXPECT_LT(glm::distance(glm::abs(p), Vec3(0.05, 0.1, 0.0015)), 1e-7);
}

TEST(SupportPoints, OfASphereLeaveOutLittleInAnyDirection) {
  const TriMesh ball = makeSphere(1, 100).value();
  const auto points = supportPoints(ball.vertices);
  EXPECT_LE(points.size(), static_cast<std::size_t>(kSupportDirections));
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 out = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
    double reach = 0;
    for (const Vec3 p : points) reach = std::max(reach, glm::dot(p, out));
    worst = std::max(worst, 1 - reach);
  }
  EXPECT_LT(worst, 0.004);
}

}  // namespace
}  // namespace haptics::test::mass_test
