#include "tests/common/wire/memory_link.h"

#include <gtest/gtest.h>

#include "tests/common/wire/transport_end.h"

namespace haptics::memory_link_test {
namespace {

using End = test::TransportEnd;

struct Pair {
  MemoryLink link;
  End client{link.takeClient()};
  End server{link.takeServer()};
};

TEST(MemoryLink, DeliversNothingUntilPumped) {
  Pair pair;
  pair.client.transport->send("hello");
  EXPECT_EQ(pair.server.heard, "");
  EXPECT_EQ(pair.client.transport->backlog(), 5U);
  EXPECT_TRUE(pair.link.pump());
  EXPECT_EQ(pair.server.heard, "hello");
  EXPECT_EQ(pair.client.transport->backlog(), 0U);
  EXPECT_EQ(pair.client.drained, 1);
  EXPECT_FALSE(pair.link.pump());
}

TEST(MemoryLink, DeliversAtMostTheLimitInEachDirection) {
  Pair pair;
  pair.client.transport->send("abcdef");
  pair.server.transport->send("123456");
  pair.link.pump(4);
  EXPECT_EQ(pair.server.heard, "abcd");
  EXPECT_EQ(pair.client.heard, "1234");
  EXPECT_EQ(pair.client.drained, 0);
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "abcdef");
  EXPECT_EQ(pair.client.heard, "123456");
}

TEST(MemoryLink, KeepsBytesForAnEndThatHasNotStarted) {
  MemoryLink link;
  End client(link.takeClient());
  client.transport->send("early");
  link.settle();
  End server(link.takeServer());
  link.settle();
  EXPECT_EQ(server.heard, "early");
}

TEST(MemoryLink, DeliversWhatWasSentBeforeClose) {
  Pair pair;
  pair.client.transport->send("last words");
  pair.client.transport->close("done");
  pair.client.transport->send("too late");
  EXPECT_EQ(pair.client.closed, 0);
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "last words");
  EXPECT_EQ(pair.client.closed, 1);
  EXPECT_EQ(pair.client.reason, "done");
  EXPECT_EQ(pair.server.closed, 1);
  EXPECT_EQ(pair.server.reason, "closed by the peer");
}

TEST(MemoryLink, ClosesForTheFirstReasonGiven) {
  Pair pair;
  pair.client.transport->close("first");
  pair.client.transport->close("second");
  pair.link.settle();
  EXPECT_EQ(pair.client.reason, "first");
  EXPECT_EQ(pair.client.closed, 1);
}

TEST(MemoryLink, DeliversNothingToAnEndThatClosed) {
  Pair pair;
  pair.client.transport->close("done");
  pair.server.transport->send("unheard");
  pair.link.settle();
  EXPECT_EQ(pair.client.heard, "");
  EXPECT_EQ(pair.client.closed, 1);
  EXPECT_EQ(pair.server.closed, 1);
}

TEST(MemoryLink, LosesWhatIsOnTheWayWhenCut) {
  Pair pair;
  pair.client.transport->send("lost");
  pair.link.cut("cable pulled");
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "");
  for (const End* end : {&pair.client, &pair.server}) {
    EXPECT_EQ(end->closed, 1);
    EXPECT_EQ(end->reason, "cable pulled");
  }
}

TEST(MemoryLink, TellsTheOtherEndWhenOneIsDestroyed) {
  Pair pair;
  pair.client.transport.reset();
  pair.server.transport->send("into the void");
  pair.link.settle();
  EXPECT_EQ(pair.client.closed, 0);
  EXPECT_EQ(pair.server.closed, 1);
}

TEST(MemoryLink, LetsAnEndBeDestroyedByItsOwnCallback) {
  MemoryLink link;
  End server(link.takeServer());
  std::unique_ptr<Transport> client = link.takeClient();
  client->start({.received = [&](std::span<const char>) { client.reset(); }, .drained = {}, .closed = {}});
  server.transport->send("bye");
  server.transport->send("again");
  link.settle();
  EXPECT_EQ(client, nullptr);
  EXPECT_EQ(server.closed, 1);
}

TEST(MemoryLink, LetsItsEndsOutliveIt) {
  auto link = std::make_unique<MemoryLink>();
  End client(link->takeClient());
  link.reset();
  client.transport->send("nowhere");
  EXPECT_EQ(client.transport->backlog(), 7U);
}

TEST(MemoryLink, AnswersWaitForTheNextPump) {
  MemoryLink link;
  End client(link.takeClient());
  std::unique_ptr<Transport> server = link.takeServer();
  server->start({.received = [&](std::span<const char>) { server->send("pong"); }, .drained = {}, .closed = {}});
  client.transport->send("ping");
  link.pump();
  EXPECT_EQ(client.heard, "");
  link.pump();
  EXPECT_EQ(client.heard, "pong");
}

}  // namespace
}  // namespace haptics::memory_link_test
