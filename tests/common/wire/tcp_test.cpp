#include "common/wire/tcp.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "tests/common/wire/transport_end.h"

namespace haptics::tcp_test {
namespace {

using End = test::TransportEnd;

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

class Tcp : public testing::Test {
 protected:
  /// Serves events until the condition holds; generous, for machines that are slow or instrumented.
  void serveUntil(const std::function<bool()>& condition) {
    const Timer look = loop_.every(milliseconds(1), [&] {
      if (condition()) loop_.stop();
    });
    const Timer limit = loop_.after(seconds(30), [&] { loop_.stop(); });
    loop_.run();
    ASSERT_TRUE(condition()) << "not within 30 s";
  }

  /// The accepted end is not started, and so not read.
  void connect(std::unique_ptr<Transport>& connected, std::unique_ptr<Transport>& accepted) {
    auto listener = TcpListener::open(loop_, {"127.0.0.1", 0}, [&](auto t) { accepted = std::move(t); });
    ASSERT_TRUE(listener) << listener.error().text();
    const TcpConnector connector(loop_, (*listener)->local(), [&](Result<std::unique_ptr<Transport>> result) {
      ASSERT_TRUE(result) << result.error().text();
      connected = std::move(*result);
    });
    serveUntil([&] { return accepted && connected; });
  }

  void connect() {
    std::unique_ptr<Transport> connected, accepted;
    connect(connected, accepted);
    client_.emplace(std::move(connected));
    server_.emplace(std::move(accepted));
  }

  EventLoop loop_;
  std::optional<End> client_, server_;
};

TEST_F(Tcp, CarriesBytesBothWays) {
  connect();
  client_->transport->send("from the client");
  server_->transport->send("from ");
  server_->transport->send("the server");
  serveUntil([&] { return client_->heard.size() == 15 && server_->heard.size() == 15; });
  EXPECT_EQ(server_->heard, "from the client");
  EXPECT_EQ(client_->heard, "from the server");
  EXPECT_GE(client_->drained, 1);
  EXPECT_EQ(client_->transport->backlog(), 0U);
}

TEST_F(Tcp, NamesItsPeer) {
  connect();
  EXPECT_THAT(server_->transport->peer(), testing::StartsWith("127.0.0.1:"));
}

TEST_F(Tcp, CarriesMegabytesInOrder) {
  connect();
  std::string sent;
  for (std::uint32_t i = 0; i < 2'000'000; ++i) sent += static_cast<char>(i * 2'654'435'761U >> 24);
  client_->transport->send(sent);
  serveUntil([&] { return server_->heard.size() == sent.size(); });
  EXPECT_EQ(server_->heard, sent);
  serveUntil([&] { return client_->drained > 0; });
  EXPECT_EQ(client_->transport->backlog(), 0U);
}

TEST_F(Tcp, ShowsABacklogSoonWhenThePeerDoesNotRead) {
  std::unique_ptr<Transport> connected, accepted;
  connect(connected, accepted);
  End client(std::move(connected));
  std::size_t sent_bytes = 0;
  int idle = 0;
  const Timer sender = loop_.every(milliseconds(1), [&] {
    if (client.transport->backlog() > 0) {
      ++idle;
      return;
    }
    idle = 0;
    client.transport->send(std::string(100'000, 'x'));
    sent_bytes += 100'000;
  });
  serveUntil([&] { return idle > 50; });
  EXPECT_GT(client.transport->backlog(), 0U);
  EXPECT_LT(sent_bytes, 64U << 20);
}

TEST_F(Tcp, SendsWhatIsQueuedBeforeItCloses) {
  connect();
  const std::string sent(3'000'000, 'q');
  server_->transport->send(sent);
  server_->transport->close("enough");
  server_->transport->send("too late");
  EXPECT_EQ(server_->closed, 0);  // not from within
  serveUntil([&] { return client_->closed == 1 && server_->closed == 1; });
  EXPECT_EQ(client_->heard, sent);
  EXPECT_EQ(client_->reason, "closed by the peer");
  EXPECT_EQ(server_->reason, "enough");
}

TEST_F(Tcp, DeliversTheLastMessageToAPeerThatIsStillSending) {
  connect();
  const Timer chatter = loop_.every(milliseconds(1), [&] { client_->transport->send(std::string(200'000, 'c')); });
  serveUntil([&] { return server_->heard.size() > 400'000; });
  server_->transport->send("refused");
  server_->transport->close("refused");
  server_->transport.reset();  // as a server does that forgets the session at once
  serveUntil([&] { return client_->closed == 1; });
  EXPECT_EQ(client_->heard, "refused");
  EXPECT_EQ(client_->reason, "closed by the peer");  // and not reset, which can overtake the message
}

TEST_F(Tcp, HearsNothingAfterItsClose) {
  connect();
  client_->transport->close("done");
  server_->transport->send("unheard");
  serveUntil([&] { return client_->closed == 1 && server_->closed == 1; });
  EXPECT_EQ(client_->heard, "");
  EXPECT_EQ(client_->closed, 1);
}

TEST_F(Tcp, GivesUpOnAPeerThatDoesNotReadWithinTheGrace) {
  connect();
  std::unique_ptr<Transport> connected, accepted;
  connect(connected, accepted);
  End client(std::move(connected));
  client.transport->send(std::string(64U << 20, 'x'));
  client.transport->close("no patience");
  serveUntil([&] { return client.closed == 1; });
  EXPECT_EQ(client.reason, "no patience");
}

TEST_F(Tcp, NoticesThatThePeerIsGone) {
  connect();
  server_->transport.reset();
  serveUntil([&] { return client_->closed == 1; });
  EXPECT_FALSE(client_->reason.empty());
  EXPECT_EQ(server_->closed, 0);
}

TEST_F(Tcp, MayBeDestroyedByItsOwnCallback) {
  connect();
  std::unique_ptr<Transport> connected, accepted;
  connect(connected, accepted);
  End client(std::move(connected));
  accepted->start({.received = [&](std::span<const char>) { accepted.reset(); }, .drained = {}, .closed = {}});
  client.transport->send("go");
  serveUntil([&] { return client.closed == 1; });
  EXPECT_EQ(accepted, nullptr);
}

TEST_F(Tcp, SaysThatAPortIsInUse) {
  const auto first = TcpListener::open(loop_, {"127.0.0.1", 0}, [](auto) {});
  ASSERT_TRUE(first) << first.error().text();
  const Endpoint taken = (*first)->local();
  const auto second = TcpListener::open(loop_, taken, [](auto) {});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().field, taken.text());
  EXPECT_THAT(second.error().reason, HasSubstr("in use"));
}

TEST_F(Tcp, SaysThatAnAddressIsNotOfThisMachine) {
  const auto listener = TcpListener::open(loop_, {"203.0.113.7", 0}, [](auto) {});  // TEST-NET-3
  ASSERT_FALSE(listener);
  EXPECT_THAT(listener.error().reason, HasSubstr("not an address of this machine"));
}

TEST_F(Tcp, ListensAgainAtOnceWhereItListenedBefore) {
  connect();
  Endpoint where;
  {
    const auto first = TcpListener::open(loop_, {"127.0.0.1", 0}, [](auto) {});
    ASSERT_TRUE(first);
    where = (*first)->local();
  }
  EXPECT_TRUE(TcpListener::open(loop_, where, [](auto) {}));
}

TEST_F(Tcp, SaysThatNobodyListens) {
  Endpoint nobody;
  {
    const auto listener = TcpListener::open(loop_, {"127.0.0.1", 0}, [](auto) {});
    nobody = (*listener)->local();
  }
  std::optional<Error> error;
  const TcpConnector connector(loop_, nobody, [&](auto result) { error = result.error(); });
  serveUntil([&] { return error.has_value(); });
  EXPECT_EQ(error->field, nobody.text());
  EXPECT_THAT(error->reason, HasSubstr("is haptic_server running there?"));
}

TEST_F(Tcp, AbandonsAnAttemptSilently) {
  const auto listener = TcpListener::open(loop_, {"127.0.0.1", 0}, [](auto) {});
  ASSERT_TRUE(listener);
  bool called = false;
  {
    const TcpConnector connector(loop_, (*listener)->local(), [&](auto) { called = true; });
  }
  const Timer end = loop_.after(milliseconds(20), [&] { loop_.stop(); });
  loop_.run();
  EXPECT_FALSE(called);
}

TEST_F(Tcp, ConnectionsThatAreRefusedUseUpNoDescriptors) {
  constexpr std::size_t kRefused = 300;
  const auto descriptors = [] {
    return static_cast<std::size_t>(std::ranges::distance(std::filesystem::directory_iterator("/proc/self/fd")));
  };
  std::size_t refused = 0;
  auto listener = TcpListener::open(loop_, {"127.0.0.1", 0}, [&](const std::unique_ptr<Transport>& accepted) {
    accepted->start({});
    accepted->close("refused");
    ++refused;
  });
  ASSERT_TRUE(listener);
  const std::size_t before = descriptors();
  std::vector<std::unique_ptr<Transport>> clients;  // that stay
  std::vector<std::unique_ptr<TcpConnector>> connectors;
  for (std::size_t i = 0; i < kRefused; ++i) {
    connectors.push_back(
        std::make_unique<TcpConnector>(loop_, (*listener)->local(), [&](Result<std::unique_ptr<Transport>> result) {
          if (result) clients.push_back(std::move(*result));
        }));
  }
  serveUntil([&] { return refused == kRefused && clients.size() == kRefused; });
  EXPECT_LT(descriptors(), before + kRefused + 100);
}

}  // namespace
}  // namespace haptics::tcp_test
