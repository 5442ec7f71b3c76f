// A mesh with a defect is loaded with a report that names it, and felt as it is away from it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::defective_meshes_tests {
namespace {

using fixture::objectOf;
using fixture::sceneOf;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 10};
constexpr double kHalf_m = 0.05;

struct Raw {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;

  std::uint32_t add(Vec3 v) {
    vertices.push_back(v);
    return static_cast<std::uint32_t>(vertices.size() - 1);
  }
  [[nodiscard]] Vec3 middle(std::size_t t) const {
    return (vertices[triangles[t][0]] + vertices[triangles[t][1]] + vertices[triangles[t][2]]) / 3.0;
  }
  /// A triangle of the top, near the corner where x and y are largest.
  [[nodiscard]] std::size_t nearCorner() const {
    const auto far = [this](std::size_t t) { return glm::distance(middle(t), Vec3(0.85, 0.9, 1) * kHalf_m); };
    std::size_t nearest = 0;
    for (std::size_t t = 1; t < triangles.size(); ++t) nearest = far(t) < far(nearest) ? t : nearest;
    return nearest;
  }
};

struct Defect {
  const char* name;
  const char* reported;
  void (*make)(Raw& cube, std::size_t t);
};

void PrintTo(const Defect& defect, std::ostream* out) { *out << defect.name; }

const Defect kDefects[] = {
    {"Hole", "3 boundary edges",
     [](Raw& cube, std::size_t t) { cube.triangles.erase(cube.triangles.begin() + static_cast<std::ptrdiff_t>(t)); }},
    {"TJunction", "1 of them T-junctions",
     [](Raw& cube, std::size_t t) {
       const auto [a, b, c] = cube.triangles[t];
       const std::uint32_t on = cube.add((cube.vertices[a] + cube.vertices[b]) * 0.5);
       cube.triangles[t] = {a, on, c};
       cube.triangles.push_back({on, b, c});
     }},
    {"Fin", "1 non-manifold edges",
     [](Raw& cube, std::size_t t) {
       const auto [a, b, c] = cube.triangles[t];
       const std::uint32_t tip = cube.add(cube.middle(t) + Vec3(0, 0, 0.004));
       cube.triangles.push_back({a, b, tip});
     }},
    {"Flipped", "3 edges with one face flipped",
     [](Raw& cube, std::size_t t) { std::swap(cube.triangles[t][1], cube.triangles[t][2]); }},
    {"Duplicate", "1 duplicate faces kept",
     [](Raw& cube, std::size_t t) { cube.triangles.push_back(cube.triangles[t]); }},
    {"Sliver", "1 slivers",
     [](Raw& cube, std::size_t t) {
       const auto [a, b, c] = cube.triangles[t];
       const Vec3 along = cube.vertices[b] - cube.vertices[a];
       const Vec3 inward = cube.vertices[c] - cube.vertices[a] * 0.5 - cube.vertices[b] * 0.5;
       const std::uint32_t at = cube.add(cube.vertices[a] + along * 0.5 + inward * 1e-4);
       cube.triangles[t] = {a, b, at};
       cube.triangles.push_back({b, c, at});
       cube.triangles.push_back({c, a, at});
     }},
    {"Crowd", "1 vertices with so many faces",
     [](Raw& cube, std::size_t t) {  // a triangle cut into a fan around a new vertex in its middle
       const auto [a, b, c] = cube.triangles[t];
       const std::uint32_t middle = cube.add(cube.middle(t));
       cube.triangles[t] = {c, a, middle};
       cube.triangles.push_back({b, c, middle});
       constexpr int kFan = kCrowdedValence + 400;
       std::uint32_t before = a;
       for (int i = 1; i <= kFan; ++i) {
         const Vec3 place = glm::mix(cube.vertices[a], cube.vertices[b], 1.0 * i / kFan);
         const std::uint32_t next = i == kFan ? b : cube.add(place);
         cube.triangles.push_back({before, next, middle});
         before = next;
       }
     }},
};

class DefectiveMesh : public ::testing::TestWithParam<Defect> {};

TEST_P(DefectiveMesh, IsReportedAndFeltAwayFromTheDefect) {
  const TriMesh good = makeBox(Vec3(2 * kHalf_m), 6).value();
  Raw cube{{good.vertices.begin(), good.vertices.end()}, good.triangles};
  GetParam().make(cube, cube.nearCorner());
  const ImportedMesh imported = canonicalise(cube.vertices, cube.triangles, {}).value();
  EXPECT_THAT(imported.report.text(), ::testing::HasSubstr(GetParam().reported));

  const auto surface = buildCollisionMesh(imported.mesh.vertices, imported.mesh.triangles);
  // Down onto the top at x, y < 0, and along it for 40 mm, 2 mm deep.
  const auto stroke = [](std::uint64_t tick) {
    const double down = 1e-4 * static_cast<double>(std::min<std::uint64_t>(tick, 70));
    const double along = 1e-4 * static_cast<double>(tick > 70 ? std::min<std::uint64_t>(tick - 70, 400) : 0);
    return Vec3(-0.045 + along, -0.013 - 0.3 * along, kHalf_m + 0.005 - down);
  };
  fixture::VirtualServo servo(stroke, kConfig);
  servo.adopt(sceneOf(1, {objectOf(1, surface, Vec3(0))}));
  servo.run(71);
  for (int i = 0; i < 400; ++i) {
    const TelemetrySample sample = servo.step();
    ASSERT_EQ(sample.object, 1U) << i;
    ASSERT_NEAR(sample.ihip.z, kHalf_m, 1e-7) << i;
    ASSERT_NEAR(sample.penetration_m, 0.002, 1e-7) << i;
    ASSERT_NEAR(sample.surfaceNormal.z, 1, 1e-6) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(EachDefect, DefectiveMesh, ::testing::ValuesIn(kDefects),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace haptics::defective_meshes_tests
