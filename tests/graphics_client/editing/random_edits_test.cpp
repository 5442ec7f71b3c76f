#include "tests/graphics_client/editing/random_edits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>

#include "common/wire/convert.h"
#include "graphics_client/editing/scene_file.h"
#include "tests/common/temporary_folder.h"
#include "tests/graphics_client/editing/edit_server.h"

namespace haptics::random_edits_test {
namespace {

using namespace test;

constexpr int kEdits = 100;

void fill(Editor& editor) {
  for (const char* name : {"ball", "cup", "bar", "table"}) ASSERT_TRUE(editor.submit(addBox(name)));
}

/// Until so many are accepted and change something.
void editAtRandom(Editor& editor, const EditServer& server, unsigned seed, int edits) {
  RandomEdits random(seed);
  std::map<v1::Operation::OpCase, int> kinds;
  for (int accepted = 0, tried = 0; accepted < edits; ++tried) {
    ASSERT_LT(tried, 20 * edits) << "the server refuses nearly all";
    const ContentHash before = contentHash(server.scene());
    RandomEdit edit = random.next(server.scene());
    if (!editor.submit(edit.transaction, edit.uploads) || contentHash(server.scene()) == before) continue;
    ++accepted;
    for (const auto& operation : edit.transaction.operations()) ++kinds[operation.op_case()];
  }
  EXPECT_EQ(kinds.size(), 8U) << "not every kind of operation was accepted";
}

class RandomlyEdited : public ::testing::TestWithParam<unsigned> {};

TEST_P(RandomlyEdited, SceneIsUndoneToTheFirstContentAndRedoneToTheLast) {
  EditServer server;
  Editor editor(server, 1);
  fill(editor);
  const ContentHash first = contentHash(server.scene());
  editAtRandom(editor, server, GetParam(), kEdits);
  const ContentHash last = contentHash(server.scene());
  EXPECT_NE(last, first);

  const std::size_t edits = server.accepted;
  for (int i = 0; i < kEdits; ++i) {
    const auto undone = editor.undo();
    ASSERT_TRUE(undone) << i << ": " << undone.error().text();
  }
  EXPECT_EQ(contentHash(server.scene()), first);
  EXPECT_EQ(server.accepted, edits + kEdits) << "each is undone by one transaction";
  for (int i = 0; i < kEdits; ++i) {
    const auto redone = editor.redo();
    ASSERT_TRUE(redone) << i << ": " << redone.error().text();
  }
  EXPECT_EQ(contentHash(server.scene()), last);
  EXPECT_FALSE(editor.history.redoOffer());
}

/// Content of each object, by name.
std::map<std::string, ContentHash> contents(const SceneVersion& scene) {
  std::map<std::string, ContentHash> hashes;
  for (const auto& object : scene.objects()) {
    ObjectRecord record = *object;
    record.id = record.revision = 0;
    hashes[record.name] = record.hash();
  }
  return hashes;
}

TEST_P(RandomlyEdited, SceneKeepsWhatSomebodyElseDidBetweenWhenTheRestIsUndone) {
  EditServer server;
  Editor editor(server, 1), other(server, 2);
  fill(editor);
  RandomEdits random(GetParam());
  constexpr int kEditsPerOther = 8;
  std::map<std::string, ContentHash> others;  // objects as the other editor left them
  bool isLastOfOther = false;
  for (int i = 0; i < 2 * kEdits || !isLastOfOther; ++i) {
    const RandomEdit edit = random.next(server.scene());
    (void)editor.submit(edit.transaction, edit.uploads);
    isLastOfOther = i % kEditsPerOther == kEditsPerOther - 1 && !server.scene().objects().empty();
    if (!isLastOfOther) continue;
    const std::string name =
        server.scene().objects()[static_cast<std::size_t>(i) % server.scene().objects().size()]->name;
    ASSERT_TRUE(other.submit(setStiffness(name, 1000 + i)));
    others[name] = contents(server.scene()).at(name);
  }
  const auto before = contents(server.scene());
  std::map<std::string, ContentHash> kept;
  std::ranges::set_intersection(others, before, std::inserter(kept, kept.end()));
  ASSERT_FALSE(kept.empty());

  int undone = 0;
  while (editor.history.undoOffer()) {
    const auto outcome = editor.undo();
    if (outcome) {
      ++undone;
      continue;
    }
    const std::string text = outcome.error().text();
    const bool isOthers = std::ranges::any_of(
        others, [&](const auto& its) { return text.starts_with("object \"" + its.first + "\": "); });
    EXPECT_TRUE(isOthers || text.find("an edit that was skipped") != std::string::npos) << text;
    editor.history.dropUndo();
  }
  EXPECT_GT(undone, 0);
  const auto after = contents(server.scene());
  for (const auto& [name, content] : kept) {
    ASSERT_TRUE(after.contains(name)) << name;
    EXPECT_EQ(after.at(name), content) << name;
  }
}

TEST_P(RandomlyEdited, SceneIsSavedAndOpenedOnAServerThatHoldsNoneOfIt) {
  EditServer server;
  Editor editor(server, 1);
  fill(editor);
  editAtRandom(editor, server, GetParam(), kEdits);
  const TemporaryFolder folder;
  const auto saved = saveScene(*server.mirrored(), folder / "table.scene");
  ASSERT_TRUE(saved) << saved.error().text();

  EditServer other;
  Editor opener(other, 1);
  ASSERT_TRUE(opener.submit(addBox("present")));
  const auto opened = openScene(folder / "table.scene", other.scene());
  ASSERT_TRUE(opened) << opened.error().text();
  const auto done = opener.submit(opened->transaction, opened->uploads);
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(contentHash(other.scene()), contentHash(server.scene()));

  EditServer beside({folder.path()});
  const auto itself = Editor(beside, 1).submit(readSceneFile((folder / "table.scene").string()).value());
  ASSERT_TRUE(itself) << itself.error().text();
  EXPECT_EQ(contentHash(beside.scene()), contentHash(server.scene()));

  ASSERT_TRUE(opener.undo());
  EXPECT_TRUE(other.scene().find("present"));
  EXPECT_EQ(other.scene().objects().size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomlyEdited, ::testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace haptics::random_edits_test
