#include "common/mesh/self_intersection_repair.h"

#include <cmath>

#include "common/mesh/generators.h"
#include "common/mesh/self_intersection_search.h"
#include "tests/common/mesh/mesh_files.h"

namespace haptics::self_intersection_repair_test {
namespace {

constexpr double kSide_m = 0.1;
constexpr double kThick_m = 0.002;
constexpr double kFarthest_m = 0.003;

/// A plate, its faces apart by kThick_m, of which the upper one dents by `deep` (m) about the middle.
TriMesh dentedPlate(double deep) {
  TriMesh mesh = makeBox({kSide_m, kSide_m, kThick_m}, 40).value();
  for (Vec3f& v : mesh.vertices) {
    const double away = std::hypot(v.x, v.y) / 0.01;
    if (v.z > 0) v.z -= static_cast<float>(deep * std::exp(-away * away));
  }
  return mesh;
}

/// A block with a slot of `wide` (m) in its top, 20 mm deep, whose walls lean into each other by `over` (m).
TriMesh slottedBlock(double wide, double over) {
  TriMesh mesh = makeBox({kSide_m, kSide_m, 0.05}, 80).value();
  for (Vec3f& v : mesh.vertices) {
    const bool onTop = v.z > 0.0249F && std::abs(v.y) < 0.015F;
    if (!onTop || std::abs(v.x) > 0.0101F) continue;
    // The middle 20 mm of the top become the walls and the bottom of the slot.
    const double along = std::abs(static_cast<double>(v.x)) / 0.01;  // 0 at the bottom, 1 at the mouth
    const double side = v.x > 0 ? 1 : v.x < 0 ? -1 : 0;
    const double half = wide / 2 - (along > 0.2 && along < 0.8 ? wide / 2 + over : 0);
    v.x = static_cast<float>(side * half);
    v.z -= static_cast<float>(0.02 * (1 - along));
  }
  return mesh;
}

std::size_t selfIntersectionsOf(const TriMesh& mesh) {
  Work work = SelfIntersectionSearch::allowance(mesh);
  const auto pairs = SelfIntersectionSearch(mesh).all(work);
  return pairs ? pairs->size() : 0;
}

double volumeOf(const TriMesh& mesh) {
  double volume = 0;
  for (const auto [a, b, c] : mesh.triangles) {
    volume += glm::dot(Vec3(mesh.vertices[a]), glm::cross(Vec3(mesh.vertices[b]), Vec3(mesh.vertices[c]))) / 6;
  }
  return volume;
}

/// The report of the mesh as it is; canonicalise() refuses what is not a mesh.
MeshReport reportOf(const TriMesh& mesh) {
  std::vector<Vec3> vertices;
  for (const Vec3f v : mesh.vertices) vertices.emplace_back(v);
  const ImportedMesh again = canonicalise(vertices, mesh.triangles, {}).value();
  EXPECT_EQ(again.mesh, mesh) << "in canonical order";
  EXPECT_EQ(again.report.droppedDegenerate, 0U);
  return again.report;
}

TEST(Mend, ReplacesTheFacesOfAPlateWhereTheyPassThroughEachOther) {
  const TriMesh torn = dentedPlate(1.2 * kThick_m);
  const std::size_t selfIntersections = selfIntersectionsOf(torn);
  ASSERT_GT(selfIntersections, 20U);
  TriMesh mesh = torn;
  const RepairReport done = repairSelfIntersections(mesh, true, kFarthest_m);
  EXPECT_EQ(done.selfIntersections, selfIntersections);
  EXPECT_EQ(done.selfIntersectionsLeft, 0U);
  EXPECT_EQ(selfIntersectionsOf(mesh), 0U);
  const MeshReport report = reportOf(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.kept, torn.triangles.size() - done.trianglesCut + done.trianglesFilled);
  EXPECT_LT(done.trianglesCut, 600U) << "only about the place";
  EXPECT_GT(done.farthest_m, 0.1 * kThick_m);
  EXPECT_LE(done.farthest_m, kFarthest_m);
  EXPECT_NEAR(volumeOf(mesh) / volumeOf(torn), 1, 0.05);
}

TEST(Mend, FillsACrackWhoseWallsPassThroughEachOtherHoweverDeep) {
  const TriMesh torn = slottedBlock(2e-5, 3e-6);
  ASSERT_GT(selfIntersectionsOf(torn), 20U);
  TriMesh mesh = torn;
  const RepairReport done = repairSelfIntersections(mesh, true, 0.0008);
  EXPECT_EQ(done.selfIntersectionsLeft, 0U);
  EXPECT_EQ(selfIntersectionsOf(mesh), 0U);
  EXPECT_TRUE(reportOf(mesh).closed());
  EXPECT_LE(done.farthest_m, 0.0008);
}

TEST(Mend, LeavesAsItIsWhatWouldChangeTooMuch) {
  const TriMesh torn = dentedPlate(4 * kThick_m);
  TriMesh mesh = torn;
  const RepairReport done = repairSelfIntersections(mesh, true, kThick_m);
  EXPECT_EQ(mesh, torn);
  EXPECT_EQ(done.selfIntersectionsLeft, done.selfIntersections);
  EXPECT_EQ(done.trianglesCut, 0U);
}

TEST(Mend, LeavesPiecesThatOverlapAndSheetsAndSoundMeshesAsTheyAre) {
  TriMesh pieces = makeBox({0.1, 0.1, 0.02}, 8).value();
  const TriMesh bar = makeBox({0.02, 0.02, 0.1}, 7).value();
  const auto first = static_cast<std::uint32_t>(pieces.vertices.size());
  pieces.vertices.insert(pieces.vertices.end(), bar.vertices.begin(), bar.vertices.end());
  for (const auto& [a, b, c] : bar.triangles) pieces.triangles.push_back({a + first, b + first, c + first});
  ASSERT_GT(selfIntersectionsOf(pieces), 20U);
  TriMesh mesh = pieces;
  EXPECT_EQ(repairSelfIntersections(mesh, true, 1).selfIntersectionsLeft, selfIntersectionsOf(pieces));
  EXPECT_EQ(mesh, pieces);

  const TriMesh sheet = dentedPlate(1.2 * kThick_m);
  mesh = sheet;
  EXPECT_EQ(repairSelfIntersections(mesh, false, kFarthest_m).selfIntersectionsLeft, selfIntersectionsOf(sheet));
  EXPECT_EQ(mesh, sheet);

  const TriMesh sound = dentedPlate(0.9 * kThick_m);
  mesh = sound;
  EXPECT_EQ(repairSelfIntersections(mesh, true, kFarthest_m).selfIntersections, 0U);
  EXPECT_EQ(mesh, sound);
}

TEST(Mend, KnowsWhatIsLeftWithoutAnotherSearch) {
  TriMesh mesh = dentedPlate(1.2 * kThick_m);
  for (Vec3f& v : mesh.vertices) {  // and one that is too deep, in a corner
    const double away = std::hypot(v.x - 0.03, v.y - 0.03) / 0.008;
    if (v.z > 0) v.z -= static_cast<float>(10 * kThick_m * std::exp(-away * away));
  }
  const std::size_t selfIntersections = selfIntersectionsOf(mesh);
  const RepairReport done = repairSelfIntersections(mesh, true, kFarthest_m);
  EXPECT_EQ(done.selfIntersections, selfIntersections);
  EXPECT_GT(done.trianglesCut, 0U);
  EXPECT_GT(done.selfIntersectionsLeft, 0U);
  EXPECT_EQ(done.selfIntersectionsLeft, selfIntersectionsOf(mesh));
}

TEST(Mend, EndsWhereAMeshIsTornAllOverAndSaysSo) {
  TriMesh mesh = makeBox({kSide_m, kSide_m, kThick_m}, 80).value();
  for (Vec3f& v : mesh.vertices) {  // 25 dents that are too deep
    const auto off = [](float x) { return x - 0.02F * std::round(x / 0.02F); };
    const double away = std::hypot(off(v.x), off(v.y)) / 0.005;
    if (v.z > 0) v.z -= static_cast<float>(4 * kThick_m * std::exp(-away * away));
  }
  const std::size_t selfIntersections = selfIntersectionsOf(mesh);
  const RepairReport done = repairSelfIntersections(mesh, true, kThick_m);
  EXPECT_EQ(done.selfIntersections, selfIntersections);
  EXPECT_GT(done.selfIntersections, 500U);
  EXPECT_FALSE(done.finished);
  EXPECT_EQ(done.selfIntersectionsLeft, selfIntersectionsOf(mesh));
  MeshReport report;
  report.repair = done;
  EXPECT_THAT(report.text(), ::testing::HasSubstr("not mended everywhere, because"));
}

class Mending : public fixture::MeshFiles {
 protected:
  static Result<ImportedMesh> importTorn(bool keep) {
    const TriMesh mesh = dentedPlate(1.2 * kThick_m);
    std::string off =
        "OFF\n" + std::to_string(mesh.vertices.size()) + ' ' + std::to_string(mesh.triangles.size()) + " 0\n";
    char line[120];
    for (const Vec3f v : mesh.vertices) {
      std::snprintf(line, sizeof line, "%.9g %.9g %.9g\n", static_cast<double>(v.x), static_cast<double>(v.y),
                    static_cast<double>(v.z));
      off += line;
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      std::snprintf(line, sizeof line, "3 %u %u %u\n", a, b, c);
      off += line;
    }
    return import("plate.off", off, {.largestExtent_m = 0.3, .keepCrossings = keep});
  }
};

TEST_F(Mending, IsPartOfImportAndInTheReport) {
  const ImportedMesh imported = importTorn(false).value();
  const MeshReport& report = imported.report;
  EXPECT_EQ(selfIntersectionsOf(imported.mesh), 0U);
  EXPECT_GT(report.repair.selfIntersections, 0U);
  EXPECT_EQ(report.kept, imported.mesh.triangles.size());
  EXPECT_THAT(report.text(), ::testing::HasSubstr("pairs of triangles that pass through each other"));
  EXPECT_THAT(report.text(), ::testing::HasSubstr("triangles cut out there and "));
  EXPECT_TRUE(report.closed());
}

TEST_F(Mending, IsLeftOutOnRequest) {
  const ImportedMesh imported = importTorn(true).value();
  EXPECT_EQ(imported.mesh.triangles, dentedPlate(0).triangles);
  EXPECT_GT(selfIntersectionsOf(imported.mesh), 0U);
  EXPECT_EQ(imported.report.repair.selfIntersectionsLeft, selfIntersectionsOf(imported.mesh));
  EXPECT_THAT(imported.report.text(), ::testing::HasSubstr("of them left as they are"));
}

}  // namespace
}  // namespace haptics::self_intersection_repair_test
