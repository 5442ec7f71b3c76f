#include "haptic_server/scene/recent_edits.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace haptics::recent_edits_test {
namespace {

RecentEdits::Edit edit(std::uint64_t revision) {
  auto made = std::make_shared<AcceptedEdit>();
  made->commit.revision = revision;
  return made;
}

void expectEqual(const RecentEdits& edits, const std::deque<RecentEdits::Edit>& expected) {
  ASSERT_EQ(edits.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(edits[i], expected[i]);
  if (expected.empty()) return;
  EXPECT_EQ(edits.front(), expected.front());
  EXPECT_EQ(edits.back(), expected.back());
}

TEST(RecentEdits, AreAQueue) {
  std::mt19937_64 random(1);
  RecentEdits edits;
  std::deque<RecentEdits::Edit> expected;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const bool grow = random() % 100 < (i < 2000 ? 70 : 30);
    if (grow || expected.empty()) {
      edits.push_back(expected.emplace_back(edit(i)));
    } else {
      edits.pop_front();
      expected.pop_front();
    }
    expectEqual(edits, expected);
  }
}

TEST(RecentEdits, LeaveCopiesAsTheyAre) {
  RecentEdits edits;
  for (std::uint64_t i = 0; i < 200; ++i) edits.push_back(edit(i));
  const RecentEdits copy = edits;
  edits.push_back(edit(200));
  for (int i = 0; i < 150; ++i) edits.pop_front();
  ASSERT_EQ(copy.size(), 200U);
  for (std::uint64_t i = 0; i < 200; ++i) EXPECT_EQ(copy[i]->commit.revision, i);
  EXPECT_EQ(edits.front()->commit.revision, 150U);
}

TEST(RecentEdits, LetGoOfWhatIsPopped) {
  RecentEdits edits;
  std::weak_ptr<const AcceptedEdit> first;
  for (std::uint64_t i = 0; i < 64; ++i) {
    edits.push_back(edit(i));
    if (i == 0) first = edits.front();
  }
  for (int i = 0; i < 32; ++i) edits.pop_front();
  EXPECT_TRUE(first.expired());
}

}  // namespace
}  // namespace haptics::recent_edits_test
