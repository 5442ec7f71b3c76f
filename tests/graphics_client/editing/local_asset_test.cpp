#include "graphics_client/editing/local_asset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/mesh/mesh_asset.h"
#include "tests/common/temporary_folder.h"

namespace haptics::local_asset_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class LocalAssets : public ::testing::Test {
 protected:
  /// A tetrahedron with a side of so many units.
  [[nodiscard]] fs::path tetrahedron(const std::string& side) const {
    const fs::path file = folder / "a.obj";
    std::ofstream(file) << "v 0 0 0\nv " << side << " 0 0\nv 0 " << side << " 0\nv 0 0 " << side
                        << "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    return file;
  }
  [[nodiscard]] double largestSideOf(const std::string& side) const {
    const auto mesh = readMeshFileOfAnyUnit(tetrahedron(side), {});
    EXPECT_TRUE(mesh) << mesh.error().text();
    const Vec3 size = mesh->report.boxMax_m - mesh->report.boxMin_m;
    return std::max({size.x, size.y, size.z});
  }

  const test::TemporaryFolder folder;
};

TEST_F(LocalAssets, TakeMetresAsTheyAreAndSeeMillimetres) {
  EXPECT_NEAR(largestSideOf("0.04"), 0.04, 1e-6);
  EXPECT_NEAR(largestSideOf("1"), 1, 1e-6);
  EXPECT_NEAR(largestSideOf("40"), 0.04, 1e-6);
  EXPECT_NEAR(largestSideOf("1000"), 1, 1e-6);
  EXPECT_NEAR(largestSideOf("5000"), kScaledTo_m, 1e-6);
}

TEST_F(LocalAssets, HaveTheHashOfTheirBytes) {
  const auto mesh = readMeshFile(tetrahedron("0.04"), {});
  ASSERT_TRUE(mesh) << mesh.error().text();
  const auto decoded = decodeMesh(mesh->asset.bytes);
  ASSERT_TRUE(decoded) << decoded.error().text();
  EXPECT_EQ(mesh->asset.hash, hashOf(*decoded));
}

TEST_F(LocalAssets, NameTheFileThatIsNoMesh) {
  std::ofstream(folder / "words.obj") << "These are words.\n";
  for (const char* name : {"words.obj", "words.txt", "none.obj"}) {
    const auto mesh = readMeshFileOfAnyUnit(folder / name, {});
    ASSERT_FALSE(mesh);
    EXPECT_THAT(mesh.error().text(), HasSubstr((folder / name).string()));
  }
}

TEST_F(LocalAssets, EndWhenTheyAreToStop) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(readMeshFileOfAnyUnit(tetrahedron("0.04"), stop.get_token()));
}

TEST(ObjectName, IsThatOfTheFileInTheCharactersThatANameHas) {
  EXPECT_EQ(objectNameOf("/a/left hand.v2.stl"), "left_hand.v2");
  EXPECT_EQ(objectNameOf("/a/\xc3\xa4.obj"), "__");
  EXPECT_EQ(objectNameOf("/a/" + std::string(200, 'x') + ".obj").size(), 58U);
}

}  // namespace
}  // namespace haptics::local_asset_test
