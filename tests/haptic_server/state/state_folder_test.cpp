#include "haptic_server/state/state_folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>

#include "common/mesh/file_bytes.h"
#include "tests/haptic_server/state/kept_scene.h"

namespace haptics::state_folder_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

constexpr SessionId kAlice = 11;
constexpr SessionId kBob = 12;

std::vector<std::string> namesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

void flipByte(const fs::path& file, std::size_t at) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekg(static_cast<std::streamoff>(at));
  const int byte = stream.get();
  stream.seekp(static_cast<std::streamoff>(at));
  stream.put(static_cast<char>(byte ^ 1));
}

/// While it lives, no file of this process may grow beyond so many bytes: as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(std::size_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

class StateFolderTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::size_t logSize() const { return fs::file_size(folder / "log"); }
  void keepABox() const { KeptScene(folder.path(), 41).accept(kAlice, 1, edit(add("a"))); }
  /// Of a box with the surface, whose assets are so many, after another start.
  [[nodiscard]] ObjectAssets assetsKeptOf(const SurfaceEdit& surface, std::size_t count) const {
    ContentHash root;
    {
      KeptScene first(folder.path());
      root = first.accept(kAlice, 1, edit(add("a"), setSurface(surface)))->commit.root;
      EXPECT_THAT(namesIn(folder / "assets"), testing::SizeIs(count));
    }
    KeptScene second(folder.path());
    EXPECT_EQ(second.version().root(), root);
    return second.sequencer.assetsOf(second.version().find("a")->id);
  }
  TemporaryFolder folder;
};

TEST_F(StateFolderTest, GoesOnWhereTheLastServerWas) {
  ContentHash root;
  {
    KeptScene first(folder.path(), 41);
    first.accept(kAlice, 1, edit(add("a"), add("gone"), remove("gone")));
    first.accept(kBob, 1, edit(add("b", box(0.2)), moveTo("a", {1, 2, 3})));
    root = first.version().root();
  }
  KeptScene second(folder.path(), 42);
  EXPECT_THAT(second.said, IsEmpty());
  EXPECT_EQ(second.version().root(), root);
  EXPECT_EQ(second.sequencer.history()->epoch, 41U) << "nothing was lost: clients resume";
  EXPECT_EQ(second.sequencer.history()->edits.size(), 2U);
  const auto again = second.accept(kBob, 1, edit(add("b", box(0.2))));
  EXPECT_EQ(again->commit.revision, 2U) << "a resent edit is known";
  EXPECT_THAT(again->reports, ElementsAre("b: made"));
  EXPECT_EQ(second.version().revision(), 2U);
  const auto next = second.accept(kAlice, 2, edit(add("c")));
  EXPECT_EQ(next->commit.put[0].id, 4U) << "no id is given twice, not even one that was never seen";
}

TEST_F(StateFolderTest, IsOneServersAtATime) {
  const KeptScene first(folder.path());
  const auto second = StateFolder::open(folder.path(), 1, {});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text(), HasSubstr("another server uses this folder"));
}

TEST_F(StateFolderTest, MakesTheFolderAndSaysWhenItCannot) {
  const KeptScene scene(folder / "new/state");
  EXPECT_TRUE(fs::exists(folder / "new/state/log"));
  std::ofstream(folder / "file") << "x";
  const auto refusal = StateFolder::open(folder / "file", 1, {});
  ASSERT_FALSE(refusal);
  EXPECT_THAT(refusal.error().text(), HasSubstr((folder / "file").string()));
}

TEST_F(StateFolderTest, AnIncompleteLastRecordCostsNothingElse) {
  {
    KeptScene first(folder.path(), 41);
    first.accept(kAlice, 1, edit(add("a")));
    first.accept(kAlice, 2, edit(moveTo("a", {1, 0, 0})));
  }
  fs::resize_file(folder / "log", logSize() - 1);
  KeptScene second(folder.path(), 42);
  EXPECT_EQ(second.version().revision(), 1U);
  EXPECT_EQ(second.sequencer.history()->epoch, 41U) << "no edit in it was answered";
  EXPECT_THAT(second.said, ElementsAre(HasSubstr("incomplete")));
  EXPECT_THAT(namesIn(folder.path()), ElementsAre("assets", "checkpoint", "lock", "log"));
  EXPECT_EQ(second.accept(kAlice, 2, edit(moveTo("a", {1, 0, 0})))->commit.revision, 2U);
}

TEST_F(StateFolderTest, ADamagedLogIsKeptAsideAndTheNewStateIsWhole) {
  std::size_t twoEdits = 0;
  {
    KeptScene first(folder.path(), 41);
    first.accept(kAlice, 1, edit(add("a")));
    first.accept(kAlice, 2, edit(moveTo("a", {1, 0, 0})));
    twoEdits = logSize();
    first.accept(kAlice, 3, edit(moveTo("a", {2, 0, 0})));
    first.accept(kAlice, 4, edit(remove("a")));
  }
  flipByte(folder / "log", twoEdits + 30);
  const std::string damaged = readFile(folder / "log").value();
  {
    KeptScene second(folder.path(), 42);
    EXPECT_EQ(second.version().revision(), 2U);
    EXPECT_EQ(second.sequencer.history()->epoch, 42U);
    EXPECT_THAT(second.said, ElementsAre(HasSubstr("at byte " + std::to_string(twoEdits))));
    const auto names = namesIn(folder.path());
    ASSERT_EQ(names.size(), 5U);
    EXPECT_THAT(names[4], HasSubstr("log.damaged-"));
    EXPECT_EQ(readFile(folder / names[4]).value(), damaged);
  }
  const KeptScene third(folder.path(), 43);
  EXPECT_THAT(third.said, IsEmpty());
  EXPECT_EQ(third.version().revision(), 2U);
  EXPECT_EQ(third.sequencer.history()->epoch, 42U);
}

TEST_F(StateFolderTest, ADamagedBeginningIsRestoredFromItsCopy) {
  std::size_t beginning = 0;
  {
    KeptScene first(folder.path(), 41);
    beginning = logSize();
    first.accept(kAlice, 1, edit(add("a")));
  }
  for (std::size_t at = 0; at < beginning; at += 7) {
    flipByte(folder / "log", at);
    const KeptScene second(folder.path(), 42);
    ASSERT_EQ(second.version().revision(), 1U) << at;
    ASSERT_EQ(second.sequencer.history()->epoch, 41U);
    ASSERT_THAT(second.said, ElementsAre(HasSubstr("restored from its copy")));
  }
  const KeptScene third(folder.path(), 43);
  EXPECT_THAT(third.said, IsEmpty());
}

TEST_F(StateFolderTest, ADamagedCopyIsReplaced) {
  keepABox();
  flipByte(folder / "checkpoint", 30);
  { const KeptScene second(folder.path(), 42); }
  flipByte(folder / "log", 30);
  const KeptScene third(folder.path(), 43);
  EXPECT_EQ(third.version().revision(), 1U);
  EXPECT_EQ(third.sequencer.history()->epoch, 41U);
}

TEST_F(StateFolderTest, ZerosInPlaceOfALastRecordAreNotCalledLost) {
  keepABox();
  std::ofstream(folder / "log", std::ios::binary | std::ios::app) << std::string(4096, '\0');
  const KeptScene second(folder.path(), 42);
  EXPECT_EQ(second.version().revision(), 1U);
  EXPECT_EQ(second.sequencer.history()->epoch, 41U);
  EXPECT_THAT(second.said, ElementsAre(HasSubstr("no edit in them was answered")));
  EXPECT_THAT(namesIn(folder.path()), ElementsAre("assets", "checkpoint", "lock", "log")) << "nothing to look into";
}

TEST_F(StateFolderTest, AMissingLogIsMadeGoodFromTheCheckpoint) {
  ContentHash root;
  {
    KeptScene first(folder.path(), 41, 3000);
    for (std::uint64_t i = 1; i <= 20; ++i) first.accept(kAlice, i, edit(add(numbered("o", i))));
    root = first.version().root();
  }
  const std::size_t copied = fs::file_size(folder / "checkpoint");
  for (const bool empty : {false, true}) {
    fs::remove(folder / "log");
    if (empty) std::ofstream(folder / "log");
    const KeptScene second(folder.path(), 42);
    EXPECT_GT(second.version().revision(), 0U);
    EXPECT_LE(second.version().revision(), 20U);
    EXPECT_EQ(second.sequencer.history()->epoch, 42U);
    EXPECT_THAT(second.said, ElementsAre(HasSubstr("that of revision " + std::to_string(second.version().revision()))));
    EXPECT_GE(fs::file_size(folder / "checkpoint"), copied) << "not that of a fresh scene";
  }
}

TEST_F(StateFolderTest, WhatCannotBeReadAtAllIsKeptAsideAndTheServerStarts) {
  { const KeptScene first(folder.path()); }
  flipByte(folder / "log", logSize() - 1);
  flipByte(folder / "checkpoint", logSize() - 1);
  const std::string before = readFile(folder / "log").value();
  {
    KeptScene second(folder.path(), 42);
    EXPECT_THAT(second.said, ElementsAre(HasSubstr("A NEW ONE IS BEGUN")));
    const auto names = namesIn(folder.path());
    ASSERT_EQ(names.size(), 6U);
    EXPECT_THAT(names[2], HasSubstr("checkpoint.damaged-"));
    EXPECT_THAT(names[5], HasSubstr("log.damaged-"));
    EXPECT_EQ(readFile(folder / names[5]).value(), before);
    second.accept(kAlice, 1, edit(add("a")));
  }
  const KeptScene third(folder.path(), 43);
  EXPECT_THAT(third.said, IsEmpty());
  EXPECT_EQ(third.version().revision(), 1U);
}

TEST_F(StateFolderTest, AssetsWithoutALogAreSaidAndKept) {
  keepABox();
  fs::remove(folder / "log");
  fs::remove(folder / "checkpoint");
  const KeptScene second(folder.path(), 42);
  EXPECT_THAT(second.said, ElementsAre(HasSubstr("there are assets but neither log nor checkpoint")));
  EXPECT_EQ(namesIn(folder / "assets").size(), 1U);
}

TEST_F(StateFolderTest, ACheckpointReplacesALogThatHasGrown) {
  constexpr std::size_t kAfter_bytes = 3000;
  ContentHash root;
  std::size_t largest = 0;
  {
    KeptScene first(folder.path(), 41, kAfter_bytes);
    first.accept(kAlice, 1, edit(add("a"), add("b", box(0.2))));
    for (std::uint64_t i = 2; i <= 200; ++i) {
      first.accept(kAlice, i, edit(moveTo("a", {double(i), 0, 0})));
      largest = std::max(largest, logSize());
    }
    root = first.version().root();
  }
  EXPECT_LT(largest, 200'000U) << "200 edits of 300 bytes, remembered ones included";
  KeptScene second(folder.path(), 42);
  EXPECT_EQ(second.version().root(), root);
  EXPECT_EQ(second.sequencer.history()->epoch, 41U);
  EXPECT_EQ(second.sequencer.history()->edits.size(), 200U);
  EXPECT_EQ(second.accept(kAlice, 150, edit(remove("a")))->commit.revision, 150U);
  EXPECT_TRUE(std::holds_alternative<Error>(second.sequencer.submit(kAlice, 2, edit(remove("a"))))) << "forgotten";
}

TEST_F(StateFolderTest, MeshesGoWithTheCheckpointThatNoLongerNamesThem) {
  KeptScene scene(folder.path(), 41, 3000);
  scene.accept(kAlice, 1, edit(add("a", box(0.1)), add("b", box(0.2))));
  scene.accept(kAlice, 2, edit(RemeshObject{named("b"), box(0.3)}));
  EXPECT_EQ(namesIn(folder / "assets").size(), 3U) << "an edit in the log still names the old one";
  for (std::uint64_t i = 3; i <= 60; ++i) scene.accept(kAlice, i, edit(moveTo("a", {double(i), 0, 0})));
  const std::vector<std::string> left = namesIn(folder / "assets");
  std::vector<std::string> expected = {scene.version().find("a")->mesh.hex(), scene.version().find("b")->mesh.hex()};
  std::ranges::sort(expected);
  EXPECT_EQ(left, expected);
  scene.accept(kAlice, 61, edit(RemeshObject{test::named("b"), box(0.2)}));
  EXPECT_EQ(namesIn(folder / "assets").size(), 3U) << "is written again when it comes back";
}

TEST_F(StateFolderTest, MeshesGoAlsoWhenNoServerLivesLong) {
  std::size_t most = 0;
  for (std::uint64_t start = 1; start <= 60; ++start) {
    KeptScene scene(folder.path(), 41, 5000);
    scene.accept(kAlice, start,
                 start == 1 ? edit(add("a")) : edit(RemeshObject{named("a"), box(0.01 * double(start))}));
    most = std::max(most, namesIn(folder / "assets").size());
  }
  EXPECT_GT(most, 5U);
  EXPECT_LT(most, 40U);
}

TEST_F(StateFolderTest, AFullDiskRejectsEditsUntilThereIsRoomAgain) {
  KeptScene scene(folder.path(), 41);
  scene.accept(kAlice, 1, edit(add("a")));
  const auto before = scene.sequencer.history();
  {
    const FullDisk full(logSize() + 100);
    for (std::uint64_t seq = 2; seq <= 3; ++seq) {
      const auto outcome = scene.sequencer.submit(kAlice, seq, edit(moveTo("a", {double(seq), 0, 0})));
      ASSERT_TRUE(std::holds_alternative<Error>(outcome));
      EXPECT_EQ(std::get<Error>(outcome).field, "state");
      EXPECT_THAT(std::get<Error>(outcome).reason, Not(HasSubstr(folder.path().string())));
    }
    EXPECT_EQ(std::get<Error>(scene.sequencer.submit(kAlice, 9, edit(add("b", box(0.7))))).field, "state");
    EXPECT_EQ(scene.sequencer.history(), before);
  }
  EXPECT_THAT(scene.said, ElementsAre(HasSubstr("rejected until")));
  EXPECT_EQ(scene.accept(kAlice, 4, edit(moveTo("a", {4, 0, 0})))->commit.revision, 2U);
  EXPECT_THAT(scene.said, ElementsAre(HasSubstr("rejected until"), HasSubstr("kept again")));
}

TEST_F(StateFolderTest, WhatAFullDiskRejectedIsNotThereAfterACrash) {
  {
    KeptScene scene(folder.path(), 41);
    scene.accept(kAlice, 1, edit(add("a")));
    const FullDisk full(logSize() + 100);
    scene.sequencer.submit(kAlice, 2, edit(moveTo("a", {2, 0, 0})));
  }
  const KeptScene second(folder.path(), 42);
  EXPECT_EQ(second.version().revision(), 1U);
  EXPECT_EQ(second.sequencer.history()->epoch, 41U) << "the log was left whole";
  EXPECT_THAT(second.said, IsEmpty());
}

TEST_F(StateFolderTest, ACheckpointThatFindsNoRoomLetsTheLogGrow) {
  KeptScene scene(folder.path(), 41, 2000);
  for (std::uint64_t i = 1; logSize() < 2000; ++i) scene.accept(kAlice, i, edit(add(numbered("o", i))));
  fs::create_directory(folder / "log.new");  // no file can be made there
  const std::size_t before = logSize();
  scene.accept(kBob, 1, edit(moveTo("o1", {1, 0, 0})));
  EXPECT_GT(logSize(), before);
  fs::remove(folder / "log.new");
}

TEST_F(StateFolderTest, KeepsTheFieldsAndValuesOfSurfaces) {
  const ObjectAssets assets = assetsKeptOf(spottedSurface(), 3);
  EXPECT_NE(assets.textureField, nullptr);
  EXPECT_EQ(*assets.frictionScale->values, std::vector<float>(8, 0.5F));
}

TEST_F(StateFolderTest, KeepsLayersAndTheMapOfTheDynamicCoefficient) {
  SurfaceEdit surface;
  const MappedFamily mapped{{}, {.tile_m = 0.01}};
  const LayeredFamily layers{LayeredFamily::Combination::kProduct, {{1, mapped}, {-2, mapped}}};
  surface.texture = TextureEdit{Texture{.family = layers, .amplitude_m = 1e-3},
                                {MappedSource{SpotNoiseSource{.seed = 5}, true, true, 0},
                                 MappedSource{SpotNoiseSource{.seed = 6}, true, true, 1}}};
  surface.friction =
      FrictionEdit{.friction = {0.6, 0.3, 0, std::monostate{}, 0, PerVertexScale{}}, .dynamicSource = sameValues(0.5F)};
  const ObjectAssets assets = assetsKeptOf(surface, 4);
  EXPECT_NE(assets.textureField, nullptr);
  EXPECT_EQ(*assets.dynamicFrictionScale->values, std::vector<float>(8, 0.5F));
}

TEST_F(StateFolderTest, KeepsWhatIsGrownOrGivesUpTheTextureWithIt) {
  SurfaceEdit surface;
  surface.texture = TextureEdit{Texture{.family = GrownFamily{}, .amplitude_m = 1e-3},
                                {GrownSource{GrownReactionDiffusionSource{.wavelength_m = 0.01, .seed = 5}}}};
  Commit commit;
  {
    KeptScene first(folder.path());
    commit = first.accept(kAlice, 1, edit(add("a"), setSurface(surface)))->commit;
    EXPECT_THAT(namesIn(folder / "assets"), testing::SizeIs(2));
  }
  {
    KeptScene second(folder.path());
    EXPECT_EQ(second.version().root(), commit.root);
    EXPECT_DOUBLE_EQ(second.sequencer.assetsOf(1).textureField->at(Vec3(0.05)).value, 5);
  }
  fs::remove(folder / "assets" / commit.put[0].assets()[1].hash.hex());
  KeptScene third(folder.path());
  EXPECT_FALSE(third.version().find("a")->material.surface.texture);
  EXPECT_EQ(third.version().find("a")->mesh, commit.put[0].mesh);
}

TEST_F(StateFolderTest, KeepsWhatStiffnessAndSoftnessFollow) {
  SurfaceEdit surface;
  surface.stiffnessOver =
      SurfaceMapEdit{SurfaceMap{0.5, MappedFamily{{}, {.tile_m = 0.01}}}, std::vector<FamilySource>{spots(5)}};
  surface.softnessOver = SurfaceMapEdit{SurfaceMap{0, PerVertexScale{}}, sameValues(0.5F)};
  const ObjectAssets assets = assetsKeptOf(surface, 3);
  EXPECT_NE(assets.stiffnessField, nullptr);
  EXPECT_EQ(*assets.softnessScale->values, std::vector<float>(8, 0.5F));
}

TEST_F(StateFolderTest, ADamagedMeshCostsItsObjectUntilItIsHereAgain) {
  ContentHash mesh;
  {
    KeptScene first(folder.path(), 41);
    mesh = first.accept(kAlice, 1, edit(add("a"), add("b", box(0.2)), moveTo("a", {1, 2, 3})))->commit.put[0].mesh;
  }
  const fs::path file = folder / "assets" / mesh.hex();
  const std::string bytes = readFile(file).value();
  flipByte(file, 40);
  {
    KeptScene second(folder.path(), 42);
    EXPECT_THAT(second.said, ElementsAre(AllOf(HasSubstr("object \"a\": mesh"), HasSubstr("is damaged"))));
    EXPECT_EQ(second.sequencer.history()->epoch, 42U);
    EXPECT_EQ(second.version().revision(), 2U);
    const auto a = second.version().find("a");
    EXPECT_NE(a->mesh, mesh);
    EXPECT_EQ(a->pose.position, Vec3(1, 2, 3)) << "nothing else of it is lost";
    EXPECT_FALSE(fs::exists(file));
    EXPECT_EQ(namesIn(folder / "assets").size(), 3U) << "the damaged one aside, the placeholder, b's";
    second.accept(kAlice, 2, edit(moveTo("a", {4, 5, 6})));
  }
  {
    const KeptScene third(folder.path(), 43);
    EXPECT_THAT(third.said, ElementsAre(HasSubstr("object \"a\": mesh"))) << "as long as it is not here";
    EXPECT_EQ(third.sequencer.history()->epoch, 42U);
    EXPECT_EQ(third.version().revision(), 3U);
  }
  std::ofstream(file, std::ios::binary) << bytes;
  {
    const KeptScene fourth(folder.path(), 44);
    EXPECT_THAT(fourth.said, ElementsAre(HasSubstr("is here again")));
    EXPECT_EQ(fourth.sequencer.history()->epoch, 42U) << "nothing is lost by that";
    EXPECT_EQ(fourth.version().find("a")->mesh, mesh);
    EXPECT_EQ(fourth.version().find("a")->pose.position, Vec3(4, 5, 6));
  }
  const KeptScene fifth(folder.path(), 45);
  EXPECT_THAT(fifth.said, IsEmpty());
  EXPECT_EQ(fifth.version().find("a")->mesh, mesh);
}

TEST_F(StateFolderTest, AMissingFieldCostsOnlyTheTexture) {
  ContentHash mesh, field;
  {
    KeptScene first(folder.path());
    const auto accepted = first.accept(kAlice, 1, edit(add("a"), setSurface(spottedSurface())));
    mesh = accepted->commit.put[0].mesh;
    SurfaceProperties surface;
    surface.texture = accepted->commit.put[0].material.surface.texture;
    field = assetsOf(surface)[0].hash;
  }
  fs::remove(folder / "assets" / field.hex());
  KeptScene second(folder.path());
  EXPECT_THAT(second.said, ElementsAre(HasSubstr("object \"a\": texture")));
  const auto a = second.version().find("a");
  EXPECT_EQ(a->mesh, mesh);
  EXPECT_FALSE(a->material.surface.texture);
  EXPECT_TRUE(a->material.surface.friction);
}

TEST_F(StateFolderTest, CollectsAssetsAlsoAfterDamage) {
  {
    KeptScene first(folder.path(), 41);
    first.accept(kAlice, 1, edit(add("a"), add("gone", box(0.3))));
    first.accept(kAlice, 2, edit(remove("gone")));
  }
  flipByte(folder / "log", logSize() - 40);
  KeptScene scene(folder.path(), 42, 3000);
  for (std::uint64_t i = 1; i <= 100; ++i)
    scene.accept(kBob, i, edit(RemeshObject{named("a"), box(0.1 + 0.001 * double(i))}));
  const auto soon = std::chrono::file_clock::now() + std::chrono::hours(1);
  for (const auto& entry : fs::directory_iterator(folder / "assets")) fs::last_write_time(entry, soon);
  for (std::uint64_t i = 101; i <= 200; ++i)
    scene.accept(kBob, i, edit(RemeshObject{named("a"), box(0.1 + 0.001 * double(i))}));
  EXPECT_LT(namesIn(folder / "assets").size(), 140U) << "those made since the damage go";
}

TEST_F(StateFolderTest, HoldsSpaceInReserve) {
  constexpr std::size_t kReserve_bytes = 1U << 20;
  KeptScene scene(folder.path(), 41, 16U << 20, kReserve_bytes);
  EXPECT_EQ(fs::file_size(folder / "reserve"), kReserve_bytes);
}

/// As if another thread had taken every free descriptor.
class TakenDescriptors {
 public:
  TakenDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit limit{64, before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &limit);
    for (FileHandle handle(::open("/dev/null", O_RDONLY)); handle; handle = FileHandle(::open("/dev/null", O_RDONLY)))
      taken_.push_back(std::move(handle));
  }
  ~TakenDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
  std::vector<FileHandle> taken_;
};

TEST_F(StateFolderTest, HasDescriptorsInReserve) {
  KeptScene scene(folder.path(), 41);
  scene.accept(kAlice, 1, edit(add("a")));
  const TakenDescriptors none;
  for (std::uint64_t i = 2; i <= 5; ++i)
    EXPECT_EQ(scene.accept(kAlice, i, edit(RemeshObject{named("a"), box(0.1 * double(i))}))->commit.revision, i);
}

}  // namespace
}  // namespace haptics::state_folder_test
