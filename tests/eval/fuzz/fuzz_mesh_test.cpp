#include "tests/eval/fuzz/fuzz_mesh.h"

#include <gtest/gtest.h>

#include "tests/eval/fuzz/solid_oracle.h"

namespace haptics::eval::fuzz_mesh_test {
namespace {

class FuzzMeshes : public testing::TestWithParam<MeshKind> {};

TEST_P(FuzzMeshes, AreClosedByWhatTheyMiss) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const FuzzMesh mesh = makeMesh(GetParam(), random);
    const bool open = GetParam() == MeshKind::kSheet || GetParam() == MeshKind::kScan;
    EXPECT_EQ(mesh.closed(), !open) << seed;
    EXPECT_EQ(isClosed(mesh.triangles), !open) << seed;
    EXPECT_EQ(mesh.build()->closed(), !open) << seed;
    std::vector<TriangleIndices> all = mesh.triangles;
    all.insert(all.end(), mesh.missing.begin(), mesh.missing.end());
    EXPECT_TRUE(isClosed(all)) << seed;
  }
}

TEST_P(FuzzMeshes, FaceOutward) {
  constexpr double kBeside_m = 1e-6;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const FuzzMesh mesh = makeMesh(GetParam(), random);
    std::vector<TriangleIndices> all = mesh.triangles;
    all.insert(all.end(), mesh.missing.begin(), mesh.missing.end());
    const SolidOracle oracle(mesh.vertices, all);
    for (const std::size_t t : {std::size_t{0}, mesh.triangles.size() / 2, mesh.triangles.size() - 1}) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 corner(mesh.vertices[a]);
      const Vec3 normal = glm::normalize(glm::cross(Vec3(mesh.vertices[b]) - corner, Vec3(mesh.vertices[c]) - corner));
      const double behind = oracle.windingNumber(mesh.middleOf(t) - kBeside_m * normal);
      const double before = oracle.windingNumber(mesh.middleOf(t) + kBeside_m * normal);
      EXPECT_NEAR(behind - before, 1, 1e-6) << seed;
      EXPECT_GT(before, -0.5) << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllKinds, FuzzMeshes,
                         testing::Values(MeshKind::kBox, MeshKind::kBlob, MeshKind::kSpiky, MeshKind::kFolded,
                                         MeshKind::kSheet, MeshKind::kScan, MeshKind::kPlate, MeshKind::kMirrored));

TEST(FuzzMesh, PassesThroughItselfWhereItIsFolded) {
  int crossed = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    crossed += makeMesh(MeshKind::kFolded, random).build()->anySelfIntersecting() ? 1 : 0;
  }
  EXPECT_GT(crossed, 20);
}

}  // namespace
}  // namespace haptics::eval::fuzz_mesh_test
