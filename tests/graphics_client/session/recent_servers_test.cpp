#include "graphics_client/session/recent_servers.h"

#include <gtest/gtest.h>

namespace haptics::recent_servers_test {
namespace {

TEST(RecentServers, TheNewestIsFirstAndEachAddressIsThereOnce) {
  RecentServers recent;
  recent.add({"a:1", "old.credentials"});
  recent.add({"b:1", ""});
  recent.add({"a:1", "new.credentials"});
  const std::vector<RecentServer> expected{{"a:1", "new.credentials"}, {"b:1", ""}};
  EXPECT_EQ(recent.list(), expected);
  EXPECT_EQ(recent.credentialsOf("a:1"), "new.credentials");
  EXPECT_EQ(recent.credentialsOf("c:1"), "");
}

TEST(RecentServers, TheEleventhDropsTheOldest) {
  RecentServers recent;
  for (int i = 0; i <= 10; ++i) recent.add({"host:" + std::to_string(i), ""});
  ASSERT_EQ(recent.list().size(), RecentServers::kMax);
  EXPECT_EQ(recent.list().front().address, "host:10");
  EXPECT_EQ(recent.list().back().address, "host:1");
}

TEST(RecentServers, AListThatWasReadIsTakenInItsOrderWithoutWhatIsTooMuchEmptyOrTwice) {
  std::vector<RecentServer> read{{"new:1", "a"}, {"", "b"}, {"new:1", "stale"}};
  for (int i = 0; i < 20; ++i) read.push_back({"host:" + std::to_string(i), ""});
  const RecentServers recent(read);
  ASSERT_EQ(recent.list().size(), RecentServers::kMax);
  EXPECT_EQ(recent.list().front(), (RecentServer{"new:1", "a"}));
  EXPECT_EQ(recent.list().back().address, "host:8");
  EXPECT_EQ(RecentServers(recent.list()).list(), recent.list());
}

}  // namespace
}  // namespace haptics::recent_servers_test
