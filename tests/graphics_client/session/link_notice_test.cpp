#include "graphics_client/session/link_notice.h"

#include <gtest/gtest.h>

namespace haptics::link_notice_test {
namespace {

MirrorView viewOf(LinkState link, const std::string& text, std::uint64_t connections) {
  MirrorView view;
  view.link = link;
  view.linkText = text;
  view.connections = connections;
  return view;
}

TEST(LinkNotice, SaysNothingWhileAllIsWellOrTheFirstAttemptIsUnderWay) {
  EXPECT_EQ(noticeOf(viewOf(LinkState::kLive, "connected to a:1", 1)).text, "");
  EXPECT_EQ(noticeOf(viewOf(LinkState::kSyncing, "getting the scene from a:1", 1)).text, "");
  EXPECT_EQ(noticeOf(viewOf(LinkState::kConnecting, "connecting to a:1", 0)).text, "");
}

TEST(LinkNotice, SaysThatTheServerIsGoneAndEditsWaitOnlyWhereThereWasOne) {
  EXPECT_NE(noticeOf(viewOf(LinkState::kConnecting, "closed by the peer", 1)).text.find("The server is gone"),
            std::string::npos);
  const LinkNotice never = noticeOf(viewOf(LinkState::kConnecting, "Connection refused", 0));
  EXPECT_EQ(never.text, "No server answers; trying again. (Connection refused)");
  EXPECT_FALSE(never.isRefusal);
}

TEST(LinkNotice, SaysARefusalInTheServersWordsMadePrintable) {
  const LinkNotice notice = noticeOf(viewOf(LinkState::kRefused, "refused by the server: token\x1b[31m", 0));
  EXPECT_TRUE(notice.isRefusal);
  EXPECT_TRUE(notice.text.starts_with("refused by the server: token"));
  EXPECT_EQ(notice.text.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace haptics::link_notice_test
