#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "common/mesh/mesh_asset.h"

namespace haptics::canonicalise_test {
namespace {

using ::testing::HasSubstr;

struct Soup {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
};

Soup cubeSoup() {
  const TriMesh cube = *makeBox({1, 1, 1}, 2);
  return {{cube.vertices.begin(), cube.vertices.end()}, cube.triangles};
}

ImportedMesh canonical(Soup soup, const ImportOptions& options = {}) {
  return canonicalise(soup.vertices, std::move(soup.triangles), options).value();
}

std::string refusal(Soup soup, const ImportOptions& options = {}) {
  const auto imported = canonicalise(soup.vertices, std::move(soup.triangles), options);
  return imported ? "accepted" : imported.error().text();
}

TEST(CanonicalOrder, DoesNotDependOnTheOrderOfVertices) {
  const Soup cube = cubeSoup();
  const TriMesh expected = canonical(cube).mesh;
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::uint32_t> place(cube.vertices.size());
    std::iota(place.begin(), place.end(), 0U);
    std::shuffle(place.begin(), place.end(), random);
    Soup shuffled = cube;
    for (std::size_t v = 0; v < place.size(); ++v) shuffled.vertices[place[v]] = cube.vertices[v];
    for (auto& triangle : shuffled.triangles) {
      for (auto& v : triangle) v = place[v];
    }
    EXPECT_EQ(canonical(shuffled).mesh, expected);
  }
}

TEST(CanonicalOrder, DoesNotDependOnWhetherVerticesAreShared) {
  const Soup cube = cubeSoup();
  Soup unwelded;
  for (const auto& triangle : cube.triangles) {
    const auto first = static_cast<std::uint32_t>(unwelded.vertices.size());
    for (const std::uint32_t v : triangle) unwelded.vertices.push_back(cube.vertices[v]);
    unwelded.triangles.push_back({first, first + 1, first + 2});
  }
  const ImportedMesh welded = canonical(unwelded);
  EXPECT_EQ(welded.mesh, canonical(cube).mesh);
  EXPECT_EQ(welded.report.verticesInFile, 3 * cube.triangles.size());
  EXPECT_EQ(welded.report.verticesWelded, 3 * cube.triangles.size() - cube.vertices.size());
}

/// A sphere of stripes between two poles, each triangle with corners of its own; every one of them is off its place by as much
/// as float64 rounds, or by less than the skin.
Soup stripes(double off_m, unsigned seed) {
  constexpr int kAround = 12, kUp = 6;
  constexpr double kRadius_m = 0.03;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> some(-off_m, off_m);
  const auto at = [&](int u, int v) {
    const double a = 2 * std::numbers::pi * u / kAround, b = std::numbers::pi * v / kUp;
    const Vec3 exact = kRadius_m * Vec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
    return exact + Vec3(some(random), some(random), some(random));
  };
  Soup soup;
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {a, b, c});
    soup.triangles.push_back({first, first + 1, first + 2});
  };
  for (int u = 0; u < kAround; ++u) {
    for (int v = 0; v < kUp; ++v) {
      if (v > 0) add(at(u, v), at(u, v + 1), at(u + 1, v));
      if (v < kUp - 1) add(at(u + 1, v), at(u, v + 1), at(u + 1, v + 1));
    }
  }
  return soup;
}

TEST(Cracks, OfRoundingAreClosed) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const double off_m = std::array{0.0, 1e-18, 5e-9}.at(seed % 3);
    const ImportedMesh imported =
        canonical(stripes(off_m, seed), {.unit_m = std::pow(10, static_cast<int>(seed) % 7 - 3)});
    EXPECT_TRUE(imported.report.closed()) << seed << ": " << imported.report.text();
    EXPECT_EQ(imported.mesh.vertices.size(), 12 * 5 + 2) << seed;
    EXPECT_EQ(imported.report.closedParts, 1) << seed;
    EXPECT_EQ(imported.report.verticesInFile,
              imported.report.verticesWelded + imported.report.verticesJoined + imported.mesh.vertices.size());
    EXPECT_TRUE(checkMesh(imported.mesh)) << seed;
    const TriMesh& mesh = imported.mesh;
    EXPECT_EQ(canonicalise({mesh.vertices.begin(), mesh.vertices.end()}, mesh.triangles, {})->mesh, mesh) << seed;
  }
  EXPECT_GT(canonical(stripes(5e-9, 1)).report.verticesJoined, 12U);
}

TEST(Cracks, ThatAreMeantStay) {
  EXPECT_GT(canonical(stripes(1e-6, 1)).report.boundaryEdges, 100U);
  // Two sheets 10 nm apart, whose rims run the same way.
  Soup sheets{{{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}}, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}}};
  for (std::size_t v = 0; v < 4; ++v) sheets.vertices.push_back(sheets.vertices[v] + Vec3(0, 0, 1e-8));
  EXPECT_EQ(canonical(sheets).report.boundaryEdges, 8U);
  EXPECT_EQ(canonical(sheets).report.verticesJoined, 0U);
}

TEST(CanonicalOrder, DoesNotDependOnUnusedVerticesOrTheSignOfZero) {
  const Soup cube = cubeSoup();
  Soup other = cube;
  for (Vec3& v : other.vertices) {
    for (int axis = 0; axis < 3; ++axis) v[axis] = v[axis] == 0 ? -0.0 : v[axis];
  }
  other.vertices.emplace_back(9, 9, 9);
  const ImportedMesh imported = canonical(other);
  EXPECT_EQ(hashOf(imported.mesh), hashOf(canonical(cube).mesh));
  EXPECT_EQ(imported.report.verticesUnused, 1U);
  EXPECT_TRUE(checkMesh(imported.mesh));
}

TEST(CanonicalOrder, KeepsTheOrderOfTrianglesTheirWindingAndFirstCorner) {
  const Soup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{3, 2, 1}, {1, 2, 0}}};
  const TriMesh mesh = canonical(soup).mesh;
  EXPECT_EQ(mesh.vertices, (std::vector<Vec3f>{{1, 1, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {2, 1, 3}}));

  Soup swapped = soup;
  std::swap(swapped.triangles[0], swapped.triangles[1]);
  EXPECT_NE(hashOf(canonical(swapped).mesh), hashOf(mesh));
  Soup turned = soup;
  turned.triangles[0] = {2, 1, 3};
  EXPECT_NE(hashOf(canonical(turned).mesh), hashOf(mesh));
}

TEST(CanonicalOrder, IsKeptByCanonicalisingAgain) {
  const TriMesh once = canonical(cubeSoup()).mesh;
  EXPECT_EQ(canonical({{once.vertices.begin(), once.vertices.end()}, once.triangles}).mesh, once);
}

TEST(Canonicalise, DropsAndCountsWhatCannotBeFelt) {
  Soup soup = cubeSoup();
  const std::size_t good = soup.triangles.size();
  const auto count = static_cast<std::uint32_t>(soup.vertices.size());
  soup.triangles.insert(soup.triangles.begin(), {{0, 0, 1}, {0, 1, count}, {5, 5, 5}});
  soup.vertices.push_back(soup.vertices[0]);
  soup.triangles.push_back({0, count, 1});  // two corners at one place; count is now in range
  const MeshReport report = canonical(soup).report;
  EXPECT_EQ(report.trianglesInFile, good + 4);
  EXPECT_EQ(report.kept, good);
  EXPECT_EQ(report.droppedDegenerate, 4U);
  EXPECT_EQ(report.droppedOutOfRange, 0U);
  EXPECT_TRUE(report.closed());

  soup.triangles.push_back({0, 1, 1000});
  EXPECT_EQ(canonical(soup).report.droppedOutOfRange, 1U);
}

TEST(Canonicalise, CountsPartsThatAreInsideOutButNoHollows) {
  const auto turned = [](Soup soup) {
    for (auto& t : soup.triangles) std::swap(t[1], t[2]);
    return soup;
  };
  const auto with = [](Soup soup, const Soup& other, double scale, double aside) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vec3 v : other.vertices) soup.vertices.push_back(scale * v + Vec3(aside));
    for (const auto& t : other.triangles) soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return soup;
  };
  const Soup cube = cubeSoup();
  const auto counts = [](const Soup& soup) {
    const MeshReport report = canonical(soup).report;
    return std::pair(report.closedParts, report.insideOutParts);
  };
  EXPECT_EQ(counts(cube), std::pair(std::uint64_t{1}, std::uint64_t{0}));
  EXPECT_EQ(counts(turned(cube)), std::pair(std::uint64_t{1}, std::uint64_t{1}));
  EXPECT_EQ(counts(with(cube, turned(cube), 0.5F, 0)), std::pair(std::uint64_t{2}, std::uint64_t{0}));
  EXPECT_EQ(counts(with(cube, turned(cube), 0.5F, 9)), std::pair(std::uint64_t{2}, std::uint64_t{1}));
  EXPECT_NE(canonical(turned(cube)).report.text().find("inside out"), std::string::npos);
}

TEST(Canonicalise, CountsHolesFinsFlipsAndDuplicates) {
  Soup cube = cubeSoup();
  EXPECT_TRUE(canonical(cube).report.closed());

  Soup hole = cube;
  hole.triangles.pop_back();
  EXPECT_EQ(canonical(hole).report.boundaryEdges, 3U);
  EXPECT_FALSE(canonical(hole).report.closed());

  Soup flipped = cube;
  std::swap(flipped.triangles[0][1], flipped.triangles[0][2]);
  EXPECT_EQ(canonical(flipped).report.inconsistentEdges, 3U);

  Soup fin = cube;
  fin.vertices.emplace_back(5, 6, 7);
  fin.triangles.push_back(
      {fin.triangles[0][0], fin.triangles[0][1], static_cast<std::uint32_t>(fin.vertices.size() - 1)});
  EXPECT_EQ(canonical(fin).report.nonManifoldEdges, 1U);
  EXPECT_EQ(canonical(fin).report.boundaryEdges, 2U);

  Soup twice = cube;
  const auto [a, b, c] = cube.triangles[3];
  twice.triangles.push_back({c, b, a});
  EXPECT_EQ(canonical(twice).report.duplicateFaces, 1U);
  EXPECT_EQ(canonical(twice).report.nonManifoldEdges, 3U);
  EXPECT_EQ(canonical(twice).report.kept, cube.triangles.size() + 1);
}

TEST(Canonicalise, FindsTheLargestValenceAndTheMeanEdge) {
  Soup fan{{{0, 0, 0}}, {}};
  const std::uint32_t n = 300;
  for (std::uint32_t i = 0; i < n; ++i) fan.vertices.emplace_back(std::cos(6.0 * i / n), std::sin(6.0 * i / n), 0);
  for (std::uint32_t i = 1; i < n; ++i) fan.triangles.push_back({0, i, i + 1});
  const MeshReport report = canonical(fan).report;
  EXPECT_EQ(report.maxValence, n - 1);
  EXPECT_NEAR(report.meanEdge_m, (n * 1.0 + (n - 1) * 2 * std::sin(3.0 / n)) / (2 * n - 1), 1e-6);
}

TEST(Canonicalise, RefusesVerticesThatAreNotNumbersByTheirIndex) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Soup soup = cubeSoup();
    soup.vertices[7].z = bad;
    EXPECT_THAT(refusal(soup), HasSubstr("vertex 7 (from 0) is not finite"));
  }
}

TEST(Canonicalise, RefusesWhatIsEmptyOrHasNoArea) {
  EXPECT_THAT(refusal({}), HasSubstr("no face"));
  EXPECT_THAT(refusal({{{0, 0, 0}}, {}}), HasSubstr("no face"));
  EXPECT_THAT(refusal({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}}}), HasSubstr("no triangle has area"));
  EXPECT_THAT(refusal({{}, {{0, 1, 2}}}), HasSubstr("not there"));
}

TEST(Scaling, AppliesTheUnit) {
  const ImportedMesh imported = canonical(cubeSoup(), {.unit_m = 0.001});
  EXPECT_EQ(imported.report.scale_m, 0.001);
  EXPECT_EQ(Vec3f(imported.report.boxMax_m), Vec3f(0.0005F));
}

TEST(Scaling, ByAPowerOfTwoChangesNothingElse) {
  const Soup cube = cubeSoup();
  const TriMesh one = canonical(cube).mesh;
  for (const int exponent : {-10, 10}) {
    TriMesh scaled = canonical(cube, {.unit_m = std::ldexp(1, exponent)}).mesh;
    for (Vec3f& v : scaled.vertices) v *= std::ldexp(1.0F, -exponent);
    EXPECT_EQ(scaled, one);
  }
}

TEST(Scaling, ToALongestSideCentresTheBoxOfWhatIsUsed) {
  Soup soup{{{10, 0, 0}, {14, 0, 0}, {10, 1, 0}, {999, 999, 999}}, {{0, 1, 2}}};
  const MeshReport report = canonical(soup, {.unit_m = 7, .largestExtent_m = 0.2}).report;
  EXPECT_NEAR(report.scale_m, 0.05, 1e-15);
  EXPECT_EQ(Vec3f(report.boxMin_m), Vec3f(-0.1F, -0.025F, 0));
  EXPECT_EQ(Vec3f(report.boxMax_m), Vec3f(0.1F, 0.025F, 0));
}

TEST(Scaling, IsRefusedWhenItDoesNotFitFloat32OrMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(cubeSoup(), {.unit_m = 1e39}), HasSubstr("vertex 0 (from 0) does not fit into float32"));
  EXPECT_THAT(refusal({{{0, 0, 0}, {1, 0, 0}, {0, 1e39, 0}}, {{0, 1, 2}}}), HasSubstr("vertex 2 (from 0)"));
  EXPECT_THAT(refusal(cubeSoup(), {.unit_m = 1e-60}), HasSubstr("no triangle has area"));
  EXPECT_THAT(refusal(cubeSoup(), {.unit_m = 0}), HasSubstr("unit_m"));
  EXPECT_THAT(refusal(cubeSoup(), {.unit_m = nan}), HasSubstr("unit_m"));
  EXPECT_THAT(refusal(cubeSoup(), {.largestExtent_m = -1}), HasSubstr("largest_extent_m"));
  EXPECT_THAT(refusal({{{1, 1, 1}}, {{0, 0, 0}}}, {.largestExtent_m = 1}), HasSubstr("largest_extent_m"));
  EXPECT_THAT(refusal({{{-1e308, 0, 0}, {1e308, 0, 0}, {0, 1e308, 0}}, {{0, 1, 2}}}, {.largestExtent_m = 1}),
              HasSubstr("largest_extent_m"));
}

TEST(MeshReport, TellsEverythingThatIsNotZeroInOneLine) {
  Soup soup = cubeSoup();
  soup.triangles[0] = {0, 0, 1};
  const std::string line = canonical(soup, {.unit_m = 0.001}).report.text();
  EXPECT_THAT(line, HasSubstr("47 of 48 triangles kept, 1 degenerate triangles dropped, 3 boundary edges"));
  EXPECT_THAT(line, HasSubstr("size 1 x 1 x 1 mm, scale 0.001"));
  EXPECT_THAT(line, ::testing::Not(HasSubstr("closed")));
}

}  // namespace
}  // namespace haptics::canonicalise_test
