#include "common/mesh/mesh_asset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "mesh_files.h"

namespace haptics::mesh_asset_test {
namespace {

using fixture::raw;
using fixture::tetrahedron;
using ::testing::HasSubstr;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::string refusedField(const TriMesh& mesh) {
  const auto checked = checkMesh(mesh);
  return checked ? "accepted" : checked.error().field;
}

TEST(MeshAsset, ComesBackFromItsBytesAsItWas) {
  const TriMesh mesh = tetrahedron();
  const std::string bytes = encodeMesh(mesh);
  EXPECT_EQ(bytes.size(), 24U + 12 * 4 + 12 * 4);
  EXPECT_EQ(decodeMesh(bytes).value(), mesh);
}

TEST(MeshAsset, IsLaidOutAsDocumented) {
  TriMesh mesh;
  mesh.vertices = {{1, 2, 3}, {4, 5, 6}, {7, 8, 10}};
  mesh.triangles = {{0, 1, 2}};
  std::string expected = "HMSH" + raw(std::uint32_t{1}) + raw(std::uint64_t{3}) + raw(std::uint64_t{1});
  for (const float x : {1.F, 2.F, 3.F, 4.F, 5.F, 6.F, 7.F, 8.F, 10.F}) expected += raw(x);
  for (const std::uint32_t v : {0U, 1U, 2U}) expected += raw(v);
  EXPECT_EQ(encodeMesh(mesh), expected);
}

TEST(MeshAsset, IsHashedAsItsBytes) {
  const TriMesh mesh = tetrahedron();
  const std::string bytes = encodeMesh(mesh);
  EXPECT_EQ(hashOf(mesh), Hasher().add(std::as_bytes(std::span(bytes))).finish());
}

TEST(MeshAsset, HashStaysTheSameFromVersionToVersion) {
  EXPECT_EQ(hashOf(tetrahedron()).hex(), "61db70be20f8f480808a171a59eae803224b456b6b03baec590586b89389fd7e");
}

TEST(MeshAsset, IsRefusedWhenCutOffAnywhere) {
  const std::string bytes = encodeMesh(tetrahedron());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decodeMesh(std::string_view(bytes).substr(0, size))) << size << " bytes";
  }
  EXPECT_FALSE(decodeMesh(bytes + '\0'));
}

TEST(MeshAsset, WithAFlippedBitIsRefusedOrHasAnotherHash) {
  const TriMesh mesh = tetrahedron();
  const ContentHash hash = hashOf(mesh);
  std::string bytes = encodeMesh(mesh);
  int refusedOnes = 0, others = 0;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    const auto decoded = decodeMesh(bytes);
    if (decoded) {
      EXPECT_NE(hashOf(*decoded), hash) << "bit " << bit;
      EXPECT_EQ(encodeMesh(*decoded), bytes) << "bit " << bit;
    }
    ++(decoded ? others : refusedOnes);
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
  }
  EXPECT_GT(refusedOnes, 0);
  EXPECT_GT(others, 0);
}

TEST(MeshAsset, CannotClaimMoreThanItsBytesHold) {
  const auto claim = [](std::uint64_t vertices, std::uint64_t triangles) {
    return decodeMesh("HMSH" + raw(std::uint32_t{1}) + raw(vertices) + raw(triangles)).error();
  };
  EXPECT_EQ(claim(300'000'000, 1).field, "vertex count");
  EXPECT_EQ(claim(3, 300'000'000).field, "triangle count");
  EXPECT_EQ(claim(50'000'000, 50'000'000).field, "size");
  EXPECT_EQ(claim(std::numeric_limits<std::uint64_t>::max() / 12 + 1, 1).field, "vertex count");
}

TEST(MeshAsset, OfAnotherKindOrVersionIsRefused) {
  std::string bytes = encodeMesh(tetrahedron());
  bytes[4] = 2;
  EXPECT_EQ(decodeMesh(bytes).error().field, "version");
  bytes[0] = 'X';
  EXPECT_EQ(decodeMesh(bytes).error().field, "magic");
}

TEST(CheckMesh, AcceptsWhatCanonicaliseMakes) { EXPECT_TRUE(checkMesh(tetrahedron())); }

TEST(CheckMesh, NamesTheFirstFault) {
  TriMesh mesh = tetrahedron();
  mesh.vertices[2].y = kNaN;
  EXPECT_EQ(refusedField(mesh), "vertices[2]");
  mesh.vertices[2].y = std::numeric_limits<float>::infinity();
  EXPECT_EQ(refusedField(mesh), "vertices[2]");
  mesh.vertices[2].y = -0.0F;
  EXPECT_EQ(refusedField(mesh), "vertices[2]");

  mesh = tetrahedron();
  mesh.triangles[3][1] = 4;
  EXPECT_EQ(refusedField(mesh), "triangles[3]");
  EXPECT_THAT(checkMesh(mesh).error().reason, HasSubstr("vertex 4 of 4"));
  mesh.triangles[3][1] = mesh.triangles[3][2];
  EXPECT_EQ(refusedField(mesh), "triangles[3]");

  mesh = tetrahedron();
  mesh.vertices.emplace_back(1, 1, 1);
  EXPECT_EQ(refusedField(mesh), "vertices[4]");
  EXPECT_EQ(refusedField(TriMesh{}), "triangles");
}

TEST(CheckMesh, RefusesATriangleWithoutArea) {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(refusedField(mesh), "triangles[0]");
}

TEST(HasArea, HoldsForSliversAndForTheSmallestAndLargestFloats) {
  EXPECT_TRUE(hasArea({0, 0, 0}, {20e-3F, 0, 0}, {10e-3F, 1e-6F, 0}));
  const float tiny = std::numeric_limits<float>::denorm_min(), huge = std::numeric_limits<float>::max();
  EXPECT_TRUE(hasArea({0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}));
  EXPECT_TRUE(hasArea({-huge, 0, 0}, {huge, 0, 0}, {0, huge, 0}));
  EXPECT_FALSE(hasArea({-huge, 0, 0}, {huge, 0, 0}, {0, 0, 0}));
}

}  // namespace
}  // namespace haptics::mesh_asset_test
