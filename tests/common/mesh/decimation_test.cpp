#include "common/mesh/decimation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stop_token>

#include "common/interruption/interruption.h"
#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "common/mesh/topology.h"
#include "common/mesh/triangle_distance.h"

namespace haptics::decimation_test {
namespace {

MeshReport topologyOf(const TriMesh& mesh) {
  MeshReport report;
  describeTopology(mesh, report);
  return report;
}

TEST(Decimation, LeavesOfABoxTheTwelveTrianglesThatItIs) {
  const TriMesh box = makeBox(Vec3(0.1, 0.2, 0.05), 8).value();
  const Decimation decimation(box);
  EXPECT_EQ(decimation.exact(), 12U);
  const TriMesh exact = decimation.copyOf(decimation.exact());
  EXPECT_EQ(exact.vertices.size(), 8U);
  EXPECT_TRUE(topologyOf(exact).closed());
}

TEST(Decimation, LeavesAsManyTrianglesAsAskedForOrTheNextFewer) {
  const TriMesh torus = makeTorus(0.06, 0.02, 64, 32).value();
  const Decimation decimation(torus);
  for (const std::size_t wanted : {4096U, 4095U, 3000U, 1000U, 100U}) {
    const TriMesh copy = decimation.copyOf(wanted);
    EXPECT_LE(copy.triangles.size(), wanted);
    EXPECT_GE(copy.triangles.size() + 2, wanted);
    EXPECT_TRUE(checkMesh(copy)) << checkMesh(copy).error().text();
    EXPECT_TRUE(topologyOf(copy).closed()) << wanted;
  }
  EXPECT_EQ(decimation.copyOf(4096), torus);
  EXPECT_EQ(decimation.copyOf(0).triangles.size(), decimation.fewest());
}

TEST(Decimation, KeepsVerticesWhereTheyWere) {
  const TriMesh sphere = makeSphere(0.05, 8).value();
  for (const Vec3f v : Decimation(sphere).copyOf(200).vertices) {
    EXPECT_NE(std::ranges::find(sphere.vertices, v), sphere.vertices.end());
  }
}

TEST(Decimation, OfTheSameMeshIsTheSame) {
  const TriMesh torus = makeTorus(0.06, 0.02, 32, 16).value();
  EXPECT_EQ(Decimation(torus).copyOf(300), Decimation(torus).copyOf(300));
}

/// A flat square of 10 x 10 quads: only its four corners are needed.
TEST(Decimation, KeepsTheRimOfASheet) {
  TriMesh sheet;
  constexpr std::uint32_t kSide = 11;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) sheet.vertices.push_back(0.01F * Vec3f(x, y, 0));
  }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t at = y * kSide + x;
      sheet.triangles.push_back({at, at + 1, at + kSide + 1});
      sheet.triangles.push_back({at, at + kSide + 1, at + kSide});
    }
  }
  const Decimation decimation(sheet);
  EXPECT_EQ(decimation.exact(), 2U);
  const MeshReport report = topologyOf(decimation.copyOf(2));
  EXPECT_NEAR(report.boxMax_m.x, 0.1, 1e-6);
  EXPECT_NEAR(report.boxMax_m.y, 0.1, 1e-6);
}

/// Two flat cones on one base: the planes at its sharp rim hardly say where the rim ends.
TEST(Decimation, KeepsTheRimOfALens) {
  TriMesh lens = makeSphere(0.05, 32).value();
  for (Vec3f& v : lens.vertices) v.z = std::copysign(0.01F * std::max(0.F, 0.05F - std::hypot(v.x, v.y)), v.z);
  const TriMesh copy = Decimation(lens).copyOf(lens.triangles.size() / 20);
  double farthest_m = 0;
  for (const Vec3f vertex : lens.vertices) {
    double squared = std::numeric_limits<double>::infinity();
    for (const TriangleIndices& t : copy.triangles) {
      const std::array<Vec3, 3> corner{copy.vertices[t[0]], copy.vertices[t[1]], copy.vertices[t[2]]};
      squared = std::min(squared, squaredDistance(vertex, corner));
    }
    farthest_m = std::max(farthest_m, std::sqrt(squared));
  }
  EXPECT_LT(farthest_m, 1e-5);
}

/// Three fins of fine triangles on one line.
TEST(Decimation, KeepsFacesAtWhichTheMeshIsNotManifold) {
  const TriMesh box = makeBox(Vec3(0.1), 6).value();
  TriMesh mesh = box;
  const TriangleIndices t = mesh.triangles.front();
  const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.F, 0.F, 0.3F);
  mesh.triangles.push_back({t[0], t[1], tip});
  const TriMesh copy = Decimation(mesh).copyOf(0);
  EXPECT_NE(std::ranges::find(copy.vertices, mesh.vertices[tip]), copy.vertices.end());
  EXPECT_NE(std::ranges::find(copy.vertices, mesh.vertices[t[0]]), copy.vertices.end());
  EXPECT_LT(copy.triangles.size(), box.triangles.size() / 4);
}

TEST(Decimation, MayBeInterrupted) {
  const TriMesh torus = makeTorus(0.06, 0.02, 64, 32).value();
  std::stop_source stop;
  stop.request_stop();
  const Interruptible work(stop.get_token());
  EXPECT_THROW(static_cast<void>(Decimation(torus)), Interrupted);
}

}  // namespace
}  // namespace haptics::decimation_test
