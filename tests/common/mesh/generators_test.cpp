#include "common/mesh/generators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/mesh/import.h"
#include "common/mesh/mesh_asset.h"

namespace haptics::generators_test {
namespace {

constexpr double kPi = std::numbers::pi;

struct Measures {
  double area_m2 = 0, volume_m3 = 0;  // the volume is > 0 when faces are counter-clockwise seen from outside
};

Measures measure(const TriMesh& mesh) {
  Measures sum;
  for (const auto [i, j, k] : mesh.triangles) {
    const Vec3 a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
    sum.area_m2 += glm::length(glm::cross(b - a, c - a)) / 2;
    sum.volume_m3 += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

MeshReport reportOf(const TriMesh& mesh) {
  return canonicalise({mesh.vertices.begin(), mesh.vertices.end()}, mesh.triangles, {})->report;
}

/// Closed surfaces: V - E + F.
long long eulerCharacteristic(const TriMesh& mesh) {
  const auto faces = static_cast<long long>(mesh.triangles.size());
  return static_cast<long long>(mesh.vertices.size()) - faces * 3 / 2 + faces;
}

void expectGoodMesh(const Result<TriMesh>& mesh, std::size_t triangles, long long euler) {
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_TRUE(checkMesh(*mesh));
  EXPECT_EQ(mesh->triangles.size(), triangles);
  EXPECT_EQ(eulerCharacteristic(*mesh), euler);
  const MeshReport report = reportOf(*mesh);
  EXPECT_TRUE(report.closed()) << report.text();
  EXPECT_EQ(report.duplicateFaces, 0U);
  // Canonical order is kept by canonicalise().
  EXPECT_EQ(canonicalise({mesh->vertices.begin(), mesh->vertices.end()}, mesh->triangles, {})->mesh, *mesh);
}

TEST(Box, HasItsExactAreaAndVolumeAtAnyNumberOfSegments) {
  for (const std::uint32_t n : {1U, 2U, 3U, 7U, 16U}) {
    const auto box = makeBox({0.1, 0.2, 0.3}, n);
    expectGoodMesh(box, 12 * n * n, 2);
    const auto [area_m2, volume_m3] = measure(*box);
    EXPECT_NEAR(area_m2, 2 * (0.1 * 0.2 + 0.2 * 0.3 + 0.3 * 0.1), 1e-7);
    EXPECT_NEAR(volume_m3, 0.1 * 0.2 * 0.3, 1e-8);
    const MeshReport report = reportOf(*box);
    EXPECT_EQ(Vec3f(report.boxMin_m), Vec3f(-0.05F, -0.1F, -0.15F));
    EXPECT_EQ(Vec3f(report.boxMax_m), Vec3f(0.05F, 0.1F, 0.15F));
  }
}

TEST(Sphere, LiesOnItsRadiusAndApproachesAreaAndVolumeQuadratically) {
  double lastAreaError = 1, lastVolumeError = 1;
  for (const std::uint32_t n : {4U, 8U, 16U, 32U}) {
    const double r = 0.05;
    const auto sphere = makeSphere(r, n);
    expectGoodMesh(sphere, 12 * n * n, 2);
    for (const Vec3f v : sphere->vertices) EXPECT_NEAR(glm::length(Vec3(v)), r, 1e-8);
    const auto [area_m2, volume_m3] = measure(*sphere);
    const double areaError = 1 - area_m2 / (4 * kPi * r * r), volumeError = 1 - volume_m3 / (4 * kPi / 3 * r * r * r);
    EXPECT_GT(areaError, 0);
    EXPECT_GT(volumeError, 0);
    EXPECT_LT(areaError, n == 4 ? 0.1 : lastAreaError / 3.5);
    EXPECT_LT(volumeError, n == 4 ? 0.1 : lastVolumeError / 3.5);
    lastAreaError = areaError;
    lastVolumeError = volumeError;
  }
}

TEST(Sphere, HasEvenTriangles) {
  const auto sphere = makeSphere(0.05, 32);
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const auto [i, j, k] : sphere->triangles) {
    const Vec3 a = sphere->vertices[i], b = sphere->vertices[j], c = sphere->vertices[k];
    const double area = glm::length(glm::cross(b - a, c - a)) / 2;
    smallest = std::min(smallest, area);
    largest = std::max(largest, area);
  }
  EXPECT_LT(largest / smallest, 3);
}

TEST(Sphere, IsTheSameOnEveryMachine) {
  EXPECT_EQ(hashOf(*makeSphere(0.05, 8)).hex(), "071b53449e9dcf4317d11a4c6712648d0c4f6c663f139a6d6507e82ece236806");
}

TEST(Cylinder, HasThePrismsAreaAndVolume) {
  for (const std::uint32_t n : {3U, 4U, 64U}) {
    const double r = 0.03, h = 0.1;
    const auto cylinder = makeCylinder(r, h, n);
    expectGoodMesh(cylinder, 4 * n, 2);
    const auto [area_m2, volume_m3] = measure(*cylinder);
    const double end_m2 = n * r * r * std::sin(2 * kPi / n) / 2, side_m = 2 * r * std::sin(kPi / n);
    EXPECT_NEAR(area_m2, 2 * end_m2 + n * side_m * h, 1e-8);
    EXPECT_NEAR(volume_m3, end_m2 * h, 1e-9);
  }
}

TEST(Torus, ApproachesAreaAndVolumeAndHasOneHole) {
  const double major = 0.04, minor = 0.015;
  const auto torus = makeTorus(major, minor, 128, 64);
  expectGoodMesh(torus, 2 * 128 * 64, 0);
  const auto [area_m2, volume_m3] = measure(*torus);
  EXPECT_NEAR(area_m2 / (4 * kPi * kPi * major * minor), 1, 2e-3);
  EXPECT_NEAR(volume_m3 / (2 * kPi * kPi * major * minor * minor), 1, 3e-3);
  EXPECT_LT(volume_m3, 2 * kPi * kPi * major * minor * minor);
  for (const Vec3f v : torus->vertices) {
    EXPECT_NEAR(std::hypot(std::hypot(v.x, v.y) - major, v.z), minor, 1e-8);
  }
}

std::string fieldOf(const Result<TriMesh>& mesh) { return mesh ? "made" : mesh.error().field; }

TEST(Generators, NameTheArgumentThatIsWrong) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fieldOf(makeBox({0.1, 0, 0.1}, 1)), "size_m.y");
  EXPECT_EQ(fieldOf(makeBox({0.1, 0.1, infinity}, 1)), "size_m.z");
  EXPECT_EQ(fieldOf(makeBox({0.1, 0.1, 0.1}, 0)), "segments");
  EXPECT_EQ(fieldOf(makeSphere(nan, 8)), "radius_m");
  EXPECT_EQ(fieldOf(makeSphere(-1, 8)), "radius_m");
  EXPECT_EQ(fieldOf(makeSphere(1, 0)), "segments");
  EXPECT_EQ(fieldOf(makeCylinder(0.1, 0, 8)), "height_m");
  EXPECT_EQ(fieldOf(makeCylinder(0.1, 0.1, 2)), "segments");
  EXPECT_EQ(fieldOf(makeTorus(0.1, 0.1, 8, 8)), "minor_radius_m");
  EXPECT_EQ(fieldOf(makeTorus(0.1, 0.05, 2, 8)), "major_segments");
  EXPECT_EQ(fieldOf(makeTorus(0.1, 0.05, 8, 2)), "minor_segments");
}

TEST(Generators, RefuseMoreTrianglesThanTheSystemTakesBeforeMakingThem) {
  const std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  EXPECT_EQ(fieldOf(makeBox({1, 1, 1}, most)), "segments");
  EXPECT_EQ(fieldOf(makeSphere(1, most)), "segments");
  EXPECT_EQ(fieldOf(makeCylinder(1, 1, most)), "segments");
  EXPECT_EQ(fieldOf(makeTorus(1, 0.5, most, most)), "major_segments");
}

TEST(Generators, RefuseSizesThatFloat32CannotHold) {
  EXPECT_EQ(fieldOf(makeSphere(1e39, 8)), "radius_m");
  EXPECT_EQ(fieldOf(makeSphere(1e-46, 8)), "radius_m");
  EXPECT_EQ(fieldOf(makeTorus(1, 1e-12, 8, 8)), "major_radius_m");
}

}  // namespace
}  // namespace haptics::generators_test
