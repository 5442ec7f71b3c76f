#include "haptic_server/engine/surface/force_shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/mesh/generators.h"

namespace haptics::force_shading_test {
namespace {

constexpr double kRadius_m = 0.05;
constexpr double kDegree = std::numbers::pi / 180;

std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

ClosestPoint footOf(const CollisionMesh& surface, Vec3 h) {
  int spent = 0;
  return surface.closestFoot(h, 1 << 20, spent);
}

/// From within a surface; the depth up to the smooth one.
ShadedPoint shadeWithin(const CollisionMesh& surface, const ShadingNormals& normals, Vec3 h) {
  const ClosestPoint foot = footOf(surface, h);
  const double depth_m =
      surface.isOutside(foot, h) ? -std::sqrt(foot.squaredDistance) : std::sqrt(foot.squaredDistance);
  ShadedPoint point = shade(surface, normals, foot, h, depth_m);
  point.depth_m += point.bulge_m;
  return point;
}

struct Errors {
  double angle_deg = 0;  // RMS
  double worst_deg = 0;
  double depth_m = 0;      // worst
  double forceStep_N = 0;  // worst difference of the force's steps from the true force's, k = 1000 N/m
};

/// Around a sphere, aslant, 2 mm deep, 0.1 mm a tick.
Errors aroundSphere(std::uint32_t segments) {
  const auto sphere = surfaceOf(makeSphere(kRadius_m, segments).value());
  const ShadingNormals normals(*sphere, std::numbers::pi, {});
  const Vec3 u = glm::normalize(Vec3(0.8, -0.6, 0)), v = glm::normalize(glm::cross(Vec3(0.36, 0.48, 0.8), u));
  Errors e;
  Vec3 last_N(0), lastTrue_N(0);
  int count = 0;
  for (double way = 0; way < 0.3; way += 1e-4, ++count) {
    const double angle = way / (kRadius_m - 0.002);
    const Vec3 out = u * std::cos(angle) + v * std::sin(angle);
    const Vec3 h = out * (kRadius_m - 0.002);
    const ShadedPoint p = shadeWithin(*sphere, normals, h);
    EXPECT_EQ(p.weight, 1);
    const double off_deg = std::acos(std::min(1.0, glm::dot(p.normal, out))) / kDegree;
    e.angle_deg += off_deg * off_deg;
    e.worst_deg = std::max(e.worst_deg, off_deg);
    e.depth_m = std::max(e.depth_m, std::abs(p.depth_m - 0.002));
    const Vec3 now_N = 1000 * p.depth_m * p.normal, nowTrue_N = 2.0 * out;
    if (count > 0) e.forceStep_N = std::max(e.forceStep_N, glm::length((now_N - last_N) - (nowTrue_N - lastTrue_N)));
    last_N = now_N;
    lastTrue_N = nowTrue_N;
  }
  e.angle_deg = std::sqrt(e.angle_deg / count);
  return e;
}

TEST(ForceShading, MakesASphereOf64000TrianglesRound) {
  const Errors e = aroundSphere(73);
  EXPECT_LE(e.angle_deg, 1e-3);
  EXPECT_LE(e.depth_m, 1e-7);
  EXPECT_LE(e.forceStep_N, 1e-4);
}

TEST(ForceShading, MakesASphereOf1700TrianglesRound) {
  const Errors e = aroundSphere(12);
  EXPECT_LE(e.angle_deg, 1e-3);
  EXPECT_LE(e.depth_m, 2e-6);
  EXPECT_LE(e.forceStep_N, 1e-3);
}

TEST(ForceShading, WeightsTheCornersNormalsByTheOppositeSubtriangles) {
  ShadingRecord r{};
  r.rows = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  // normals x, y, z
  EXPECT_EQ(interpolatedNormal(r, Vec3(0.2, 0.3, 0.5)), Vec3(0.2, 0.3, 0.5)) << "Eq. (1)";
  // On a line 1 mm from one end and 3 mm from the other: 1/1 and 1/3, in parts of their sum.
  const double near = 1 / 1.0, far = 1 / 3.0;
  EXPECT_EQ(interpolatedNormal(r, Vec3(near, far, 0) / (near + far)), Vec3(0.75, 0.25, 0));
  EXPECT_EQ(interpolatedNormal(r, Vec3(0, 0, 1)), r.normal(2)) << "a vertex";
}

TEST(ForceShading, LeavesTheFlatSidesOfABoxFlatRightUpToItsEdges) {
  const auto box = surfaceOf(makeBox(Vec3(0.1), 5).value());
  const ShadingNormals normals(*box, std::numbers::pi / 3, {});
  for (double y = -0.0495; y < 0.0495; y += 0.0007) {
    const ShadedPoint p = shadeWithin(*box, normals, Vec3(0.0495, y, 0.05 - 0.0003));
    EXPECT_EQ(p.weight, 1);
    EXPECT_LE(glm::length(p.normal - Vec3(0, 0, 1)), std::sin(1e-3 * kDegree));
    EXPECT_NEAR(p.depth_m, 0.0003, 1e-8);
  }
}

TEST(ForceShading, MakesTheSideOfACylinderRoundAndLeavesItsEndsFlatAndItsRimSharp) {
  const double radius = 0.02, height = 0.08;
  const auto cylinder = surfaceOf(makeCylinder(radius, height, 36).value());
  const ShadingNormals normals(*cylinder, std::numbers::pi / 3, {});
  for (double angle = 0; angle < 7; angle += 0.013) {
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const ShadedPoint side = shadeWithin(*cylinder, normals, out * (radius - 0.001) + Vec3(0, 0, height / 2 - 0.0015));
    EXPECT_LE(glm::length(side.normal - out), std::sin(0.05 * kDegree)) << angle;
    EXPECT_NEAR(side.depth_m, 0.001, 1e-6) << angle;
    const ShadedPoint end = shadeWithin(*cylinder, normals, out * (radius - 0.0006) + Vec3(0, 0, height / 2 - 0.0004));
    EXPECT_LE(glm::length(end.normal - Vec3(0, 0, 1)), std::sin(1e-3 * kDegree)) << angle;
  }
}

TEST(ForceShading, HasNoNormalOnASharpLineOrVertex) {
  const auto box = surfaceOf(makeBox(Vec3(0.1), 2).value());
  const ShadingNormals normals(*box, std::numbers::pi / 3, {});
  const Vec3 beyondEdge(0.051, 0.02, 0.051), beyondCorner(0.051, 0.051, 0.051);
  EXPECT_EQ(shade(*box, normals, footOf(*box, beyondEdge), beyondEdge, -0.0014).weight, 0);
  EXPECT_EQ(shade(*box, normals, footOf(*box, beyondCorner), beyondCorner, -0.0017).weight, 0);
}

TEST(ForceShading, TellsTheDepthOutsideOfTheSurfaceToo) {
  const auto sphere = surfaceOf(makeSphere(kRadius_m, 40).value());
  const ShadingNormals normals(*sphere, std::numbers::pi, {});
  const Vec3 out = glm::normalize(Vec3(0.3, -0.5, 0.7));
  const Vec3 h = out * (kRadius_m + 0.001);
  const ClosestPoint foot = footOf(*sphere, h);
  const ShadedPoint p = shade(*sphere, normals, foot, h, -std::sqrt(foot.squaredDistance));
  EXPECT_LE(glm::length(p.normal - out), 1e-5);
  EXPECT_NEAR(p.depth_m + p.bulge_m, -0.001, 1e-8);
}

TEST(ForceShading, FadesToTheUnshadedVectorWithoutAStepWhereThePenetrationComesNearTheCurvature) {
  const auto sphere = surfaceOf(makeSphere(kRadius_m, 10).value());
  const ShadingNormals normals(*sphere, std::numbers::pi, {});
  const Vec3 out = glm::normalize(Vec3(0.3, -0.5, 0.7));
  double last = 1;
  for (double depth = 0.001; depth < 0.0455; depth += 1e-5) {
    const double weight = shadeWithin(*sphere, normals, out * (kRadius_m - depth)).weight;
    EXPECT_LE(std::abs(weight - last), 2e-3) << depth;
    EXPECT_TRUE(depth > 0.48 * kRadius_m || weight == 1) << depth;
    last = weight;
  }
  EXPECT_EQ(last, 0);
}

TEST(ForceShading, MovesOverTheLinesOfABumpySurfaceWithoutAJump) {
  // A torus: round and hollow, its lines crossed aslant.
  const auto torus = surfaceOf(makeTorus(0.04, 0.015, 40, 24).value());
  const ShadingNormals normals(*torus, std::numbers::pi, {});
  Vec3 last(0);
  double most = 0;
  for (double s = 0; s < 6; s += 1e-4) {
    const double around = 1.7 * s;
    const Vec3 out(std::cos(s), std::sin(s), 0);
    const Vec3 h = out * 0.04 + 0.013 * (out * std::cos(around) + Vec3(0, 0, std::sin(around)));
    const ShadedPoint p = shadeWithin(*torus, normals, h);
    const Vec3 now_N = 1000 * p.depth_m * p.normal;
    if (s > 0) most = std::max(most, glm::length(now_N - last));
    last = now_N;
  }
  // The true force turns by about 2 N / 15 mm on a way of 7 um a step: 0.5 mN.
  EXPECT_LE(most, 1.5e-3);
}

/// What the force gives the hand, k = 500 N/m, in a loop over one facet of a cylinder whose facets are 10 mm wide and
/// meet at 30 degrees: 3 mm down at its middle, to near its edge, up.
TEST(ForceShading, GivesAHandAlmostNoEnergyInALoop) {
  const auto cylinder = surfaceOf(makeCylinder(0.01932, 0.1, 12).value());
  const ShadingNormals normals(*cylinder, std::numbers::pi / 3, {});
  const double apothem = 0.01932 * std::cos(15 * kDegree);
  const Vec3 out(std::cos(15 * kDegree), std::sin(15 * kDegree), 0), along(-out.y, out.x, 0);
  double energy_J = 0;
  const auto go = [&](double s0, double z0, double s1, double z1) {
    constexpr int kSteps = 3000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) / kSteps;
      const Vec3 h = out * (apothem - glm::mix(z0, z1, t)) + along * glm::mix(s0, s1, t) + Vec3(0, 0, 0.0123);
      const ShadedPoint p = shadeWithin(*cylinder, normals, h);
      energy_J += glm::dot(500 * std::max(0.0, p.depth_m) * p.normal, along * (s1 - s0) - out * (z1 - z0)) / kSteps;
    }
  };
  go(0, -0.001, 0, 0.003);
  go(0, 0.003, 0.0035, 0.003);
  go(0.0035, 0.003, 0.0035, -0.001);
  EXPECT_LE(std::abs(energy_J), 0.05e-3) << energy_J << "; 0.59 mJ without the bulge";
}

}  // namespace
}  // namespace haptics::force_shading_test
