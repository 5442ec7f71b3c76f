#include "graphics_client/editing/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/wire/convert.h"
#include "graphics_client/editing/scene_text.h"
#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::scene_file_test {
namespace {

using namespace test;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class SceneFile : public ::testing::Test {
 protected:
  SceneFile() {
    fs::remove_all(folder);
    fs::create_directories(folder);
    EXPECT_TRUE(editor.submit(addBox("cup")));
    EXPECT_TRUE(saveScene(*server.mirrored(), file));
    mesh = folder / (server.scene().find("cup")->mesh.hex() + ".mesh");
  }
  ~SceneFile() override { fs::remove_all(folder); }
  SceneFile(const SceneFile&) = delete;
  SceneFile& operator=(const SceneFile&) = delete;

  [[nodiscard]] std::string openingError() const {
    const auto opened = openScene(file, SceneVersion());
    return opened ? "" : opened.error().text();
  }

  const fs::path folder = fs::path(::testing::TempDir()) / "scene_file_test";
  const fs::path file = folder / "a b.scene";
  fs::path mesh;
  EditServer server;
  Editor editor{server, 1};
};

TEST_F(SceneFile, LiesBesideTheAssetsThatItNames) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("a b.scene", mesh.filename().string()));
}

TEST_F(SceneFile, UploadsNothingThatThePresentSceneNames) {
  const auto opened = openScene(file, server.scene());
  ASSERT_TRUE(opened);
  EXPECT_TRUE(opened->uploads.empty());
  EXPECT_EQ(opened->text, "Open a b.scene");
  ASSERT_TRUE(editor.submit(opened->transaction));
  EXPECT_EQ(server.scene().objects().size(), 1U);
}

TEST_F(SceneFile, NamesAFileThatIsMissingOrDamaged) {
  std::fstream(mesh, std::ios::in | std::ios::out | std::ios::binary).seekp(20) << 'x';
  EXPECT_THAT(openingError(), HasSubstr(mesh.string() + ": is damaged"));
  fs::remove(mesh);
  EXPECT_THAT(openingError(), HasSubstr(mesh.string() + ": there is no such file"));
  std::ofstream(file) << "operations { grow { } }";
  EXPECT_THAT(openingError(), HasSubstr(file.string() + ":1:"));
}

TEST_F(SceneFile, OffersTheAssetsBesideItThatThePresentSceneDoesNotName) {
  const auto transaction = parseSceneText(sceneText(server.scene(), ""), "test");
  ASSERT_TRUE(transaction);
  EXPECT_TRUE(assetsBeside(file, *transaction, server.scene())->empty());
  ASSERT_EQ(assetsBeside(file, *transaction, SceneVersion())->size(), 1U);
  std::fstream(mesh, std::ios::in | std::ios::out | std::ios::binary).seekp(20) << 'x';
  EXPECT_FALSE(assetsBeside(file, *transaction, SceneVersion()));
  fs::remove(mesh);
  EXPECT_TRUE(assetsBeside(file, *transaction, SceneVersion())->empty()) << "the server may hold it";
}

TEST_F(SceneFile, IsNotWrittenBeforeItsAssetsAreHere) {
  MirrorView view = *server.mirrored();
  view.meshes.clear();
  const auto saved = saveScene(view, folder / "other.scene");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().text(), HasSubstr("other.scene: cannot be written yet: assets of object \"cup\""));
  EXPECT_FALSE(fs::exists(folder / "other.scene"));
}

TEST_F(SceneFile, NamesAFileThatCannotBeWritten) {
  const auto saved = saveScene(*server.mirrored(), folder / "none" / "a.scene");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().text(), HasSubstr("none"));
}

}  // namespace
}  // namespace haptics::scene_file_test
