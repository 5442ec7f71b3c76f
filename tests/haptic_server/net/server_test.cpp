#include "haptic_server/net/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <fstream>
#include <mutex>

#include "common/wire/tcp.h"
#include "common/wire/tls.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/connections.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics::server_test {
namespace {

using namespace test;
using namespace std::chrono_literals;
using Kind = v1::Envelope;

constexpr auto kPatience = 20s;  // never reached unless something is broken

/// A program around the server, whose servo's queue the test fills.
class FakeHost final : public ServerHost {
 public:
  void push(std::uint64_t tick, std::uint64_t revision, std::uint64_t adoptionTick) {
    const std::lock_guard lock(mutex_);
    TelemetrySample sample;
    sample.tick = tick;
    sample.sceneRevision = revision;
    sample.adoptionTick = adoptionTick;
    samples_.push_back(sample);
  }
  [[nodiscard]] bool popTelemetry(TelemetrySample& sample) override {
    const std::lock_guard lock(mutex_);
    if (samples_.empty()) return false;
    sample = samples_.front();
    samples_.pop_front();
    taken.push_back(sample.tick);
    return true;
  }
  void fillStatus(v1::Status& status) override { status.set_ticks(42); }

  std::vector<std::uint64_t> taken;

 private:
  std::mutex mutex_;
  std::deque<TelemetrySample> samples_;
};

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() {
    EXPECT_TRUE(sceneService.loadStartScene(edit(add("a"))));
    sceneService.start();
    server = Server::listen(options(), sceneService, host).value();
    server->start();
  }

  Server::Options options(std::string listen = "127.0.0.1:0") {
    return {.listen = std::move(listen),
            .credentials = credentials,
            .allowInsecureLan = false,
            .identity = {"test", "simulated", 1000, 3.3}};
  }

  /// A client over TCP that beats once it has said Hello. All share one loop, which runs while the test waits.
  struct Client {
    Client(ServerTest& test_, std::uint16_t port) : test(test_) {
      const TcpConnector connector(test.loop, {"127.0.0.1", port},
                                   [this](Result<std::unique_ptr<Transport>> connected) {
                                     transport = std::move(connected).value();
                                     if (test.tls) transport = test.tls->secure(std::move(transport));
                                     raw = std::make_unique<RawClient>(*transport);
                                   });
      EXPECT_TRUE(test.waitFor([this] { return raw != nullptr; }));
    }
    void hello(SessionId session, const std::string& token) {
      v1::Envelope envelope;
      envelope.mutable_hello()->set_session(session);
      envelope.mutable_hello()->set_token(token);
      raw->send(envelope);
    }
    void join(SessionId session = kClientSession, const std::string& token = {}) {
      hello(session, token);
      beat = test.loop.every(500ms, [this] { raw->heartbeat(); });
      EXPECT_TRUE(waitFor(Kind::kSnapshotEnd));
    }
    [[nodiscard]] bool waitFor(Kind::BodyCase kind) {
      return test.waitFor([&] { return raw->count(kind) > 0; });
    }

    ServerTest& test;
    std::unique_ptr<Transport> transport;
    std::unique_ptr<RawClient> raw;
    Timer beat;
  };

  /// Sessions from 100 on.
  [[nodiscard]] std::vector<std::unique_ptr<Client>> joined(std::size_t count, const std::string& token = {}) {
    std::vector<std::unique_ptr<Client>> clients;
    for (std::size_t i = 0; i < count; ++i) {
      clients.push_back(std::make_unique<Client>(*this, server->port()));
      clients.back()->join(100 + i, token);
    }
    return clients;
  }

  template <class Condition>
  [[nodiscard]] bool waitFor(Condition condition) {
    bool held = false;
    const Timer look = loop.every(1ms, [&] {
      held = condition();
      if (held) loop.stop();
    });
    const Timer limit = loop.after(kPatience, [&] { loop.stop(); });
    loop.run();
    return held;
  }

  /// A server that wants credentials, in place of the one that does not; clients get its viewer.credentials.
  void secureServer() {
    ASSERT_TRUE(makeCredentials(folder.path()));
    credentials = readServerCredentials(folder.path()).value();
    viewer = readClientCredentials(folder / kViewerFile).value();
    editor = readClientCredentials(folder / kEditorFile).value();
    tls = TlsContext::client(viewer.serverCertificatePem).value();
    server->stop();
    server = Server::listen(options(), sceneService, host).value();
    server->start();
  }

  std::optional<ServerCredentials> credentials;
  const test::TemporaryFolder folder;
  ClientCredentials viewer, editor;
  std::optional<TlsContext> tls;
  EventLoop loop;
  FakeHost host;
  SceneMailbox mailbox;
  SceneService sceneService{{}, mailbox};
  std::unique_ptr<Server> server;
};

TEST_F(ServerTest, ServesAClientOverTcpFromWelcomeToEditLive) {
  Client client(*this, server->port());
  client.join();
  EXPECT_EQ(server->counters().clients, 1U);

  client.raw->subscribe(1000);
  host.push(1, 1, 0);
  ASSERT_TRUE(client.waitFor(Kind::kTelemetry));

  client.raw->moveObject(1, "a", 0.25);
  ASSERT_TRUE(client.waitFor(Kind::kEditReply));
  EXPECT_EQ(client.raw->all(Kind::kEditReply)[0].edit_reply().accepted().revision(), 2U);
  ASSERT_TRUE(client.waitFor(Kind::kCommit));
  EXPECT_EQ(client.raw->all(Kind::kCommit)[0].commit().root(), sceneService.history()->version.root().asBytes());
  for (std::uint64_t tick = 2; tick < 1000; ++tick) host.push(tick, tick < 500 ? 1 : 2, tick < 500 ? 0 : 500);
  ASSERT_TRUE(client.waitFor(Kind::kEditLive));
  EXPECT_EQ(client.raw->all(Kind::kEditLive)[0].edit_live().tick(), 500U);
  ASSERT_TRUE(waitFor([&] { return client.raw->all(Kind::kTelemetry).back().telemetry().tick() == 999; }));

  v1::Envelope request;
  request.mutable_status_request();
  client.raw->send(request);
  ASSERT_TRUE(client.waitFor(Kind::kStatus));
  EXPECT_EQ(client.raw->all(Kind::kStatus)[0].status().clients(), 1U);
  EXPECT_EQ(client.raw->all(Kind::kStatus)[0].status().ticks(), 42U);

  server->stop();
  ASSERT_EQ(host.taken.size(), 999U);
  for (std::size_t i = 0; i < host.taken.size(); ++i) ASSERT_EQ(host.taken[i], i + 1);
}

TEST_F(ServerTest, StoppingClosesTheClientsAndRecordsWhatIsLeft) {
  Client client(*this, server->port());
  client.join();
  for (std::uint64_t tick = 1; tick <= 50; ++tick) host.push(tick, 1, 0);
  server->stop();
  EXPECT_EQ(host.taken.size(), 50U);
  EXPECT_TRUE(waitFor([&] { return client.raw->closed.has_value(); }));
}

TEST_F(ServerTest, ANewerConnectionOfASessionReplacesTheOlder) {
  Client first(*this, server->port());
  first.join();
  Client second(*this, server->port());
  second.join();
  EXPECT_TRUE(waitFor([&] { return first.raw->closed.has_value(); }));
  EXPECT_FALSE(second.raw->closed);
  EXPECT_TRUE(waitFor([&] { return server->counters().clients == 1; }));
}

TEST_F(ServerTest, TurnsAwayTheClientThatIsOneTooMany) {
  const auto clients = joined(Admission::kMaxClients);
  Client late(*this, server->port());
  late.raw->hello(0, 0, {}, 99);
  ASSERT_TRUE(late.waitFor(Kind::kRefusal));
  EXPECT_THAT(late.raw->refusal().reason(), ::testing::HasSubstr("64"));
  EXPECT_EQ(server->counters().refusedConnections, 1U);
  EXPECT_EQ(server->counters().clients, Admission::kMaxClients);
}

TEST_F(ServerTest, LetsAClientOfTheFullServerComeBack) {
  const auto clients = joined(Admission::kMaxClients);
  Client again(*this, server->port());
  again.join(100);
  EXPECT_EQ(again.raw->count(Kind::kRefusal), 0U);
}

TEST_F(ServerTest, ServesWhoSpeaksWhileHundredsSayNothing) {
  std::vector<std::unique_ptr<Client>> silent;
  const auto more = [&] {
    for (int i = 0; i < 150; ++i) silent.push_back(std::make_unique<Client>(*this, server->port()));
  };
  more();
  Client client(*this, server->port());
  client.join();
  more();
  // At once and without a word; those that stay are told after 3 s that they should have said Hello.
  const auto dropped = [](const auto& one) { return one->raw->closed && one->raw->got.empty(); };
  EXPECT_TRUE(waitFor([&] {
    return std::count_if(silent.begin(), silent.end(), dropped) >= 300 - static_cast<int>(Connections::kMaxHalfOpen);
  }));
  EXPECT_GE(server->counters().refusedConnections, 300 - Connections::kMaxHalfOpen);
  EXPECT_EQ(server->counters().clients, 1U);
  EXPECT_FALSE(client.raw->closed) << "who is welcome is not dropped";
}

TEST_F(ServerTest, WithCredentialsWelcomesThroughTlsAndByToken) {
  secureServer();
  Client client(*this, server->port());
  v1::Envelope hello;
  hello.mutable_hello()->set_session(kClientSession);
  hello.mutable_hello()->set_token(viewer.token);
  client.raw->send(hello);
  ASSERT_TRUE(client.waitFor(Kind::kWelcome));
  EXPECT_FALSE(client.raw->all(Kind::kWelcome)[0].welcome().may_edit());
}

TEST_F(ServerTest, WithCredentialsRefusesWhoHasNoToken) {
  secureServer();
  for (const std::string& token : {std::string(), std::string(kTokenBytes, 'x')}) {
    Client client(*this, server->port());
    v1::Envelope hello;
    hello.mutable_hello()->set_session(kClientSession);
    hello.mutable_hello()->set_token(token);
    client.raw->send(hello);
    ASSERT_TRUE(client.waitFor(Kind::kRefusal));
    EXPECT_EQ(client.raw->refusal().field(), "hello.token");
    EXPECT_EQ(client.raw->count(Kind::kWelcome), 0U);
  }
}

TEST_F(ServerTest, ViewersLeavePlacesToEditors) {
  secureServer();
  const auto viewers = joined(Admission::kMaxViewers, viewer.token);
  Client late(*this, server->port());
  late.hello(99, viewer.token);
  ASSERT_TRUE(late.waitFor(Kind::kRefusal));
  EXPECT_THAT(late.raw->refusal().reason(), ::testing::HasSubstr("48 viewers"));
  Client writer(*this, server->port());
  writer.join(98, editor.token);
  EXPECT_TRUE(writer.raw->all(Kind::kWelcome)[0].welcome().may_edit());
}

TEST_F(ServerTest, OneTokenLeavesPlacesToOthers) {
  secureServer();
  std::vector<std::unique_ptr<Client>> editors;
  for (std::size_t i = 0; i < Admission::kMaxClientsOfToken; ++i) {
    editors.push_back(std::make_unique<Client>(*this, server->port()));
    editors.back()->join(100 + i, editor.token);
  }
  Client late(*this, server->port());
  late.hello(99, editor.token);
  ASSERT_TRUE(late.waitFor(Kind::kRefusal));
  EXPECT_EQ(late.raw->refusal().field(), "hello.token");
  Client other(*this, server->port());
  other.join(98, viewer.token);
}

TEST_F(ServerTest, CutsWhoseTokenIsWithdrawn) {
  secureServer();
  Client watcher(*this, server->port()), writer(*this, server->port());
  watcher.join(1, viewer.token);
  writer.join(2, editor.token);
  std::ofstream(folder / kTokensFile) << "edit " << hashOfToken(editor.token).hex() << '\n';
  ASSERT_TRUE(watcher.waitFor(Kind::kRefusal));
  EXPECT_EQ(watcher.raw->refusal().field(), "hello.token");
  EXPECT_THAT(watcher.raw->refusal().reason(), ::testing::HasSubstr("withdrawn"));
  EXPECT_TRUE(waitFor([&] { return watcher.raw->closed.has_value(); }));
  Client again(*this, server->port());
  again.hello(3, viewer.token);
  ASSERT_TRUE(again.waitFor(Kind::kRefusal));
  EXPECT_EQ(again.raw->refusal().field(), "hello.token");
  EXPECT_FALSE(writer.raw->closed);
}

TEST_F(ServerTest, ASessionIsOfOneToken) {
  secureServer();
  Client writer(*this, server->port());
  writer.join(7, editor.token);
  Client thief(*this, server->port());
  thief.hello(7, viewer.token);
  ASSERT_TRUE(thief.waitFor(Kind::kRefusal));
  EXPECT_EQ(thief.raw->refusal().field(), "hello.session");
  EXPECT_FALSE(writer.raw->closed);
}

TEST_F(ServerTest, WithCredentialsTellsAPlainClientWhatToDo) {
  secureServer();
  tls.reset();
  Client client(*this, server->port());
  client.raw->hello();
  ASSERT_TRUE(client.waitFor(Kind::kRefusal));
  EXPECT_THAT(client.raw->refusal().reason(), ::testing::HasSubstr("--credentials"));
  EXPECT_TRUE(waitFor([&] { return server->counters().refusedConnections == 1; }));
}

TEST_F(ServerTest, CountsRandomBytesAsRefused) {
  Client client(*this, server->port());
  client.raw->sendBytes("GET / HTTP/1.1\r\n\r\n");
  ASSERT_TRUE(client.waitFor(Kind::kRefusal));
  EXPECT_EQ(server->counters().refusedConnections, 1U);
}

TEST_F(ServerTest, NamesTheAddressThatItCannotListenOn) {
  const auto second = Server::listen(options("127.0.0.1:" + std::to_string(server->port())), sceneService, host);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text(), ::testing::HasSubstr(std::to_string(server->port())));
  const auto open = Server::listen(options("0.0.0.0:0"), sceneService, host);
  ASSERT_FALSE(open);
  EXPECT_THAT(open.error().text(), ::testing::HasSubstr("--allow-insecure-lan"));
  EXPECT_THAT(open.error().text(), ::testing::HasSubstr("--credentials"));
  const auto malformed = Server::listen(options("nonsense"), sceneService, host);
  ASSERT_FALSE(malformed);
  EXPECT_THAT(malformed.error().text(), ::testing::StartsWith("--listen"));
}

}  // namespace
}  // namespace haptics::server_test
