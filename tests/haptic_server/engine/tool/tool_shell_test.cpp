#include "haptic_server/engine/tool/tool_shell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <span>

#include "common/mesh/generators.h"
#include "haptic_server/engine/geometry/spaced_points.h"

namespace haptics::tool_shell_test {
namespace {

std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

using ::testing::HasSubstr;

/// How far from a point of the shell a vertex is at most.
double farthestVertex(const TriMesh& mesh, std::span<const Vec3> points) {
  double farthest = 0;
  for (const Vec3f& vertex : mesh.vertices) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& point : points) nearest = std::min(nearest, glm::distance(Vec3(vertex), point));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

TEST(ToolShell, CoversTheSurfaceAtItsSpacing) {
  constexpr double kSpacing = 0.002;
  const TriMesh sphere = makeSphere(0.02, 16).value();
  const ToolShell shell = makeToolShell(*surfaceOf(sphere), kSpacing).value();
  const auto spaced = std::span(shell.points).first(shell.spaced);
  for (std::size_t i = 0; i < spaced.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(glm::distance(spaced[i], spaced[j]), kSpacing);
  }
  EXPECT_LE(farthestVertex(sphere, spaced), 1.2 * kSpacing);
  EXPECT_NEAR(shell.radius_m, 0.02, 1e-4);
}

TEST(ToolShell, HasTheCornersAndEdgesOfABox) {
  const ToolShell shell = makeToolShell(*surfaceOf(makeBox({0.04, 0.02, 0.01}, 4).value()), 0.002).value();
  for (const double x : {-0.02, 0.02}) {
    for (const double y : {-0.01, 0.01}) {
      for (const double z : {-0.005, 0.005}) {
        EXPECT_TRUE(std::ranges::any_of(shell.points, [&](Vec3 p) { return glm::distance(p, Vec3(x, y, z)) < 1e-8; }));
      }
      int along = 0;
      for (const Vec3& p : shell.points) along += std::abs(p.x - x) < 1e-8 && std::abs(p.y - y) < 1e-8 ? 1 : 0;
      EXPECT_GE(along, 4);
    }
  }
}

TEST(ToolShell, HasEveryVertex) {
  for (const TriMesh& mesh : {makeSphere(0.02, 12).value(), makeTorus(0.02, 0.008, 48, 24).value()}) {
    const ToolShell shell = makeToolShell(*surfaceOf(mesh), 0.004).value();
    EXPECT_EQ(shell.nearVertex_m, kNearVertex_m);
    EXPECT_GT(shell.points.size(), shell.spaced);
    EXPECT_LE(farthestVertex(mesh, shell.points), kNearVertex_m);
  }
}

TEST(ToolShell, ThinsOutVerticesThatAreTooMany) {
  const TriMesh fine = makeTorus(0.02, 0.008, 128, 48).value();
  const ToolShell shell = makeToolShell(*surfaceOf(fine), 0.004).value();
  EXPECT_LE(shell.points.size(), 2000U);
  EXPECT_GT(shell.points.size(), 500U);
  EXPECT_LE(farthestVertex(fine, shell.points), shell.nearVertex_m);
  EXPECT_LT(shell.nearVertex_m, 0.004);
}

TEST(ToolShell, IsTheSameEachTime) {
  const TriMesh mesh = makeTorus(0.02, 0.008, 48, 24).value();
  EXPECT_EQ(makeToolShell(*surfaceOf(mesh), 0.002).value().points,
            makeToolShell(*surfaceOf(mesh), 0.002).value().points);
}

TEST(SharpPoints, AreThoseOfCornersAndEdges) {
  const auto box = surfaceOf(makeBox({0.04, 0.02, 0.01}, 4).value());
  const std::vector<Vec3> points = sharpPoints(*box, 0.004, kMaxToolPoints);
  EXPECT_GE(points.size(), 45U);
  for (const Vec3& p : points) {
    const int onFaces = (std::abs(std::abs(p.x) - 0.02) < 1e-8) + (std::abs(std::abs(p.y) - 0.01) < 1e-8) +
                        (std::abs(std::abs(p.z) - 0.005) < 1e-8);
    EXPECT_GE(onFaces, 2);
  }
  EXPECT_TRUE(sharpPoints(*surfaceOf(makeSphere(0.02, 16).value()), 0.002, kMaxToolPoints).empty());
  EXPECT_LE(sharpPoints(*box, 1e-7, kMaxToolPoints).size(), kMaxToolPoints);
}

TEST(ToolShell, RefusesASpacingThatIsNoneOrGivesTooManyPoints) {
  const auto box = surfaceOf(makeBox({1, 1, 1}, 1).value());
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(makeToolShell(*box, bad).error().text(), HasSubstr("it has to be positive"));
  }
  for (const double fine : {0.005, 1e-5, 1e-300}) {
    EXPECT_THAT(makeToolShell(*box, fine).error().text(), HasSubstr("more than 8192 points"));
  }
}

}  // namespace
}  // namespace haptics::tool_shell_test
