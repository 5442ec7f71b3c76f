#include "graphics_client/audience/session_subjects.h"

#include <gtest/gtest.h>

namespace haptics::session_subjects_test {
namespace {

TEST(SessionSubjects, AreNamedAfterTheSession) {
  const auto subjects = SessionSubjects::of("ward-3");
  ASSERT_TRUE(subjects);
  EXPECT_EQ(subjects->commit, "haptics.ward-3.live.commit");
  EXPECT_EQ(subjects->sceneStream, "haptics-ward-3");
  const ContentHash asset{{0xAB}};
  EXPECT_EQ(subjects->chunk(asset, 7), "haptics.ward-3.asset." + asset.hex() + ".7");
  EXPECT_EQ(subjects->chunksOf(asset.hex()), "haptics.ward-3.asset." + asset.hex() + ".*");
}

TEST(SessionSubjects, RefuseNamesThatMeanMoreToNats) {
  for (const char* name : {"", "a.b", "a b", "*", ">", "a\n", "\xC3\xA4", "012345678901234567890123456789012"}) {
    EXPECT_FALSE(SessionSubjects::of(name)) << name;
  }
  EXPECT_TRUE(SessionSubjects::of("01234567890123456789012345678901"));
}

TEST(SessionSubjects, OfTwoSessionsShareNoStream) {
  const std::string taken = SessionSubjects::of("ward")->assetStream;
  const auto other = SessionSubjects::of(taken.substr(std::string_view("haptics-").size()));
  EXPECT_FALSE(other) << other->sceneStream;
}

}  // namespace
}  // namespace haptics::session_subjects_test
