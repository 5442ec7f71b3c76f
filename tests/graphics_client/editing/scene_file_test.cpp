#include "graphics_client/editing/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"
#include "common/mesh/mesh_asset.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/generated_mesh.h"
#include "graphics_client/editing/scene_text.h"
#include "tests/common/temporary_folder.h"
#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::scene_file_test {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

/// One that no generator makes.
AssetContent tetrahedron(double side_m) {
  const std::vector<Vec3> corners{{0, 0, 0}, {side_m, 0, 0}, {0, side_m, 0}, {0, 0, side_m}};
  return std::make_shared<const TriMesh>(
      canonicalise(corners, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}, {}).value().mesh);
}

v1::Transaction addMesh(const std::string& name, const AssetContent& mesh) {
  v1::Transaction transaction;
  v1::AddObject& add = *transaction.add_operations()->mutable_add();
  add.set_name(name);
  add.mutable_mesh()->set_asset(canonicalBytes(mesh).hash().asBytes());
  return transaction;
}

class SceneFile : public ::testing::Test {
 protected:
  SceneFile() {
    fs::create_directories(folder);
    EXPECT_TRUE(editor.submit(addMesh("cup", tetrahedron(0.05)), {tetrahedron(0.05)}));
    EXPECT_TRUE(saveScene(*server.mirrored(), file));
  }

  [[nodiscard]] std::string openingError() const {
    const auto opened = openScene(file, SceneVersion());
    return opened ? "" : opened.error().text();
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    return names;
  }
  /// The root of a server that has opened it by the name of its folder, as its own scene.
  [[nodiscard]] static std::string rootOf(const fs::path& scene) {
    EditServer own({scene.parent_path()});
    Editor only(own, 1);
    const auto read = readSceneFile(scene.string());
    EXPECT_TRUE(read) << read.error().text();
    const auto done = only.submit(read.value_or(v1::Transaction()));
    EXPECT_TRUE(done) << done.error().text();
    return own.scene().root().hex();
  }
  /// Of one that holds nothing, and whose client has opened it.
  [[nodiscard]] static std::string rootByClient(const fs::path& scene) {
    EditServer empty;
    Editor only(empty, 1);
    const auto opened = openScene(scene, empty.scene());
    EXPECT_TRUE(opened) << opened.error().text();
    if (!opened) return "";
    const auto done = only.submit(opened->transaction, opened->uploads);
    EXPECT_TRUE(done) << done.error().text();
    return empty.scene().root().hex();
  }

  const TemporaryFolder above;
  const fs::path folder = above / "scenes";
  const fs::path file = folder / "a b.scene";
  EditServer server;
  Editor editor{server, 1};
};

TEST_F(SceneFile, LiesBesideTheAssetsThatItNames) {
  EXPECT_THAT(files(), UnorderedElementsAre("a b.scene", "cup.mesh"));
  EXPECT_EQ(rootOf(file), server.scene().root().hex());
  EXPECT_EQ(rootByClient(file), server.scene().root().hex());
}

TEST_F(SceneFile, WithoutAFolderNamesByTheirHashWhatNoGeneratorMakes) {
  ASSERT_TRUE(editor.submit(addBox("box")));
  const auto text = sceneFor(std::nullopt, *server.mirrored());
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_THAT(*text, HasSubstr("asset: "));
  EXPECT_THAT(*text, HasSubstr("box {"));
  EXPECT_THAT(*sceneFor(std::nullopt, *server.mirrored(), "box"), ::testing::Not(HasSubstr("asset: ")));
}

TEST_F(SceneFile, NamesAnAssetOfSeveralObjectsOnceAndLeavesOtherFilesAlone) {
  ASSERT_TRUE(editor.submit(addMesh("saucer", tetrahedron(0.05))));
  ASSERT_TRUE(saveScene(*server.mirrored(), file));
  EXPECT_THAT(files(), UnorderedElementsAre("a b.scene", "cup.mesh"));

  EditServer other;
  Editor its(other, 1);
  ASSERT_TRUE(its.submit(addMesh("cup", tetrahedron(0.06)), {tetrahedron(0.06)}));
  ASSERT_TRUE(saveScene(*other.mirrored(), folder / "other.scene"));
  EXPECT_THAT(files(), UnorderedElementsAre("a b.scene", "other.scene", "cup.mesh", "cup-2.mesh"));
  EXPECT_EQ(rootOf(file), rootByClient(file));
  EXPECT_EQ(rootOf(folder / "other.scene"), other.scene().root().hex());
}

TEST_F(SceneFile, UploadsNothingThatThePresentSceneNames) {
  const auto opened = openScene(file, server.scene());
  ASSERT_TRUE(opened);
  EXPECT_TRUE(opened->uploads.empty());
  EXPECT_EQ(opened->text, "Open a b.scene");
  ASSERT_TRUE(editor.submit(opened->transaction));
  EXPECT_EQ(server.scene().objects().size(), 1U);
}

TEST_F(SceneFile, NamesTheFieldAndTheFileThatIsDamagedOrOfAnotherVersion) {
  const std::string bytes = canonicalBytes(tetrahedron(0.05)).copy();
  const auto write = [&](const std::string& damaged) {
    std::ofstream(folder / "cup.mesh", std::ios::binary) << damaged;
    const std::string said = openingError();
    EXPECT_THAT(said, HasSubstr("operations[0].add.mesh.file: "));
    EXPECT_THAT(said, HasSubstr("cup.mesh: "));
    return said;
  };
  EXPECT_THAT(write("HMSH" + std::string(1, '\2') + bytes.substr(5)), HasSubstr("version: is 2; this program reads 1"));
  EXPECT_THAT(write("words, and more of them than a header is long"), HasSubstr("magic"));
  EXPECT_THAT(write(bytes.substr(0, bytes.size() - 1)), HasSubstr("size"));
  EXPECT_THAT(write(""), HasSubstr("is empty"));
  std::ofstream(file) << "operations { grow { } }";
  EXPECT_THAT(openingError(), HasSubstr(file.string() + ":1:"));
}

TEST_F(SceneFile, MayNameAnAssetByTheHashThatItsFileIsNamedAfter) {
  const std::string hash = server.scene().find("cup")->mesh.hex();
  std::ofstream(file) << textOf(addMesh("cup", tetrahedron(0.05)));
  fs::rename(folder / "cup.mesh", folder / (hash + ".mesh"));
  EXPECT_EQ(rootByClient(file), server.scene().root().hex());
  std::ofstream(folder / (hash + ".mesh"), std::ios::binary) << canonicalBytes(tetrahedron(0.06)).copy();
  EXPECT_THAT(openingError(), HasSubstr("is damaged"));
}

TEST_F(SceneFile, LeavesToTheServerWhatIsNotBelowItsFolder) {
  fs::rename(folder / "cup.mesh", folder.parent_path() / "cup.mesh");
  for (const char* name : {"cup.mesh", "../cup.mesh"}) {
    std::ofstream(file) << "operations { add { name: 'cup' mesh { file: '" << name << "' } } }";
    const auto opened = openScene(file, SceneVersion());
    ASSERT_TRUE(opened) << opened.error().text();
    EXPECT_EQ(opened->transaction.operations(0).add().mesh().file(), name);
    EditServer empty;
    const auto refused = Editor(empty, 1).submit(opened->transaction);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().field, "operations[0].add.mesh.file");
  }
  fs::remove(folder.parent_path() / "cup.mesh");
}

TEST_F(SceneFile, IsNotWrittenBeforeItsAssetsAreHere) {
  MirrorView view = *server.mirrored();
  view.meshes.clear();
  const auto saved = saveScene(view, folder / "other.scene");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().text(), HasSubstr("other.scene: object \"cup\": cannot be written yet"));
  EXPECT_FALSE(fs::exists(folder / "other.scene"));
}

TEST_F(SceneFile, NamesAFileThatCannotBeWritten) {
  const auto saved = saveScene(*server.mirrored(), folder / "none" / "a.scene");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().text(), HasSubstr("none"));
}

/// Every demo scene: what is saved of it has its root wherever it is opened, and names a file for no more than what came of
/// one.
TEST_F(SceneFile, OfEveryDemoSceneHasItsRootEverywhere) {
  const fs::path scans = "/usr/share/inventor/data", scenes = SCENES_FOLDER;
  std::size_t saved = 0;
  for (const auto& entry : fs::directory_iterator(scenes)) {
    if (entry.path().extension() != ".scene") continue;
    SCOPED_TRACE(entry.path().string());
    const auto read = readSceneFile(entry.path().string());
    ASSERT_TRUE(read) << read.error().text();
    const std::string text = textOf(*read);
    if (text.find("CyberHeads") != std::string::npos && !fs::exists(scans)) continue;
    EditServer original({scenes, scans});
    Editor only(original, 1);
    const auto done = only.submit(*read);
    ASSERT_TRUE(done) << done.error().text();
    const fs::path written = folder / entry.path().filename();
    const auto outcome = saveScene(*original.mirrored(), written);
    ASSERT_TRUE(outcome) << outcome.error().text();
    EXPECT_EQ(rootOf(written), original.scene().root().hex());
    EXPECT_EQ(rootByClient(written), original.scene().root().hex());
    const std::string again = textOf(readSceneFile(written.string()).value());
    for (const char* generator : {" box {", " sphere {", " cylinder {", " torus {"}) {
      const auto count = [&](const std::string& in) {
        std::size_t times = 0;
        for (std::size_t at = 0; (at = in.find(generator, at)) != std::string::npos; ++at) ++times;
        return times;
      };
      EXPECT_EQ(count(again), count(text)) << generator;
    }
    ++saved;
  }
  EXPECT_GT(saved, 15U);
}

TEST_F(SceneFile, SaysOperationsByTheirNumbersInTheFile) {
  Edit edit;
  for (int i = 0; i < 3; ++i) edit.transaction.add_operations()->mutable_remove()->mutable_object()->set_id(i + 1);
  edit.transaction.add_operations()->mutable_add()->set_name("a b");
  edit.transaction.add_operations()->mutable_remove()->mutable_object()->set_name("a b");  // the file's own
  EXPECT_EQ(removalsBefore(edit), 3);
  EXPECT_EQ(asInFile({"operations[3].add.name", "is taken; see operations[14]"}, 3).text(),
            "operations[0].add.name: is taken; see operations[11]");
  EXPECT_EQ(asInFile({"operations[1].remove.object", "is gone"}, 3).text(), "operations[1].remove.object: is gone");
  for (const char* odd : {"operations[", "operations[]", "operations[x]", "operations[99999999999].y"}) {
    EXPECT_EQ(asInFile({odd, odd}, 3).field, odd);
  }
}

TEST(GeneratedMesh, IsToldFromOthersByEveryVertex) {
  const auto recognised = [](const Result<TriMesh>& mesh) {
    const auto source = generatorOf(mesh.value());
    return source ? source->ShortDebugString() : "";
  };
  EXPECT_EQ(recognised(makeSphere(0.0123, 7)), "sphere { radius_m: 0.0123 segments: 7 }");
  EXPECT_EQ(recognised(makeSphere(0.02, 32)), "sphere { radius_m: 0.02 segments: 32 }");
  EXPECT_EQ(recognised(makeBox({0.1, 0.02, 0.003}, 3)), "box { size_m { x: 0.1 y: 0.02 z: 0.003 } segments: 3 }");
  EXPECT_EQ(recognised(makeCylinder(0.004, 0.05, 5)), "cylinder { radius_m: 0.004 height_m: 0.05 segments: 5 }");
  EXPECT_EQ(recognised(makeTorus(0.042, 0.018, 128, 64)),
            "torus { major_radius_m: 0.042 minor_radius_m: 0.018 major_segments: 128 minor_segments: 64 }");
  EXPECT_EQ(recognised(makeTorus(0.3, 0.1, 5, 3)),
            "torus { major_radius_m: 0.3 minor_radius_m: 0.1 major_segments: 5 minor_segments: 3 }");
  TriMesh moved = makeSphere(0.02, 8).value();
  moved.vertices[100].x += 1e-6F;
  EXPECT_EQ(recognised(moved), "");
  EXPECT_EQ(recognised(*std::get<std::shared_ptr<const TriMesh>>(tetrahedron(0.1))), "");
}

}  // namespace
}  // namespace haptics::scene_file_test
