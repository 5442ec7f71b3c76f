#include "common/wire/tls.h"

#include <gmock/gmock.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "common/credentials/credentials.h"
#include "common/wire/tcp.h"
#include "tests/common/temporary_folder.h"
#include "tests/common/wire/memory_link.h"
#include "tests/common/wire/transport_end.h"

namespace haptics::tls_test {
namespace {

using End = test::TransportEnd;

using testing::HasSubstr;

/// Credentials of a server, made once: key generation is not what is tested.
struct Made {
  Made() {
    const test::TemporaryFolder folder;
    EXPECT_TRUE(makeCredentials(folder.path()));
    server = readServerCredentials(folder.path()).value();
  }
  ServerCredentials server;
};
const ServerCredentials& one() {
  static const Made made;
  return made.server;
}
const ServerCredentials& another() {
  static const Made made;
  return made.server;
}
TlsContext serverOf(const ServerCredentials& credentials) {
  return TlsContext::server(credentials.certificatePem, credentials.privateKeyPem, "TLS only").value();
}
TlsContext clientOf(const ServerCredentials& credentials) {
  return TlsContext::client(credentials.certificatePem).value();
}

struct Pair {
  explicit Pair(const TlsContext& clientSide = clientOf(one()), const TlsContext& serverSide = serverOf(one()))
      : server(serverSide.secure(link.takeServer())), client(clientSide.secure(link.takeClient())) {}
  MemoryLink link;
  End server, client;
};

TEST(Tls, CarriesBytesBothWays) {
  Pair pair;
  pair.client.transport->send("before the handshake");
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "before the handshake");
  pair.server.transport->send("a");
  pair.server.transport->send("nswer");
  pair.link.settle();
  EXPECT_EQ(pair.client.heard, "answer");
  EXPECT_EQ(pair.client.transport->backlog() + pair.server.transport->backlog(), 0U);
}

TEST(Tls, CarriesBytesThatArriveOneByOne) {
  Pair pair;
  pair.client.transport->send("drip");
  while (pair.link.pump(1)) {
  }
  EXPECT_EQ(pair.server.heard, "drip");
}

TEST(Tls, CarriesMegabytesInOrder) {
  Pair pair;
  std::string sent;
  for (std::uint32_t i = 0; i < 2'000'000; ++i) sent += static_cast<char>(i * 2'654'435'761U >> 24);
  pair.client.transport->send(sent);
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, sent);
}

TEST(Tls, HidesWhatItCarries) {
  MemoryLink link;
  End client(clientOf(one()).secure(link.takeClient()));
  End eavesdropper(link.takeServer());  // hears only the first flight: it cannot answer
  client.transport->send("secret");
  link.settle();
  EXPECT_THAT(eavesdropper.heard, testing::Not(HasSubstr("secret")));
  EXPECT_EQ(client.transport->backlog(), 6U) << "waits for the handshake";
  EXPECT_EQ(client.drained, 0);
}

TEST(Tls, ShowsTheBacklogOfTheLineBelow) {
  Pair pair;
  pair.link.settle();
  pair.server.transport->send(std::string(1000, 'x'));
  EXPECT_GE(pair.server.transport->backlog(), 1000U);
  pair.link.settle();
  EXPECT_EQ(pair.server.transport->backlog(), 0U);
  EXPECT_GE(pair.server.drained, 1);
}

TEST(Tls, SendsWhatIsQueuedBeforeItCloses) {
  Pair pair;
  pair.link.settle();
  pair.server.transport->send("the last word");
  pair.server.transport->close("enough");
  pair.server.transport->send("too late");
  pair.link.settle();
  EXPECT_EQ(pair.client.heard, "the last word");
  EXPECT_EQ(pair.client.closed, 1);
  EXPECT_EQ(pair.server.closed, 1);
  EXPECT_EQ(pair.server.reason, "enough");
}

TEST(Tls, MayBeDestroyedByItsOwnCallback) {
  Pair pair;
  pair.link.settle();
  pair.server.then = [&] { pair.server.transport.reset(); };
  pair.client.transport->send("first");
  pair.client.transport->send("second");
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "first");
  EXPECT_EQ(pair.server.closed, 0);
}

TEST(Tls, MayBeClosedByItsOwnCallback) {
  Pair pair;
  pair.link.settle();
  pair.server.then = [&] { pair.server.transport->close("enough"); };
  pair.client.transport->send("first");
  pair.client.transport->send("second");
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "first");
  EXPECT_EQ(pair.server.reason, "enough");
}

TEST(Tls, OfAnotherServerIsRefusedByTheClient) {
  Pair pair(clientOf(another()));
  pair.client.transport->send("my token");
  pair.link.settle();
  EXPECT_EQ(pair.server.heard, "");
  EXPECT_THAT(pair.client.reason, HasSubstr("not the one that the credentials are of"));
  EXPECT_THAT(pair.server.reason, HasSubstr("takes this for another server"));
}

TEST(Tls, IsNoCertificateWithoutItsKey) {
  const auto stolen = TlsContext::server(one().certificatePem, another().privateKeyPem, "");
  ASSERT_FALSE(stolen);
  EXPECT_EQ(stolen.error().text(), "key: is not the certificate's");
  EXPECT_FALSE(TlsContext::server("", one().privateKeyPem, ""));
  EXPECT_FALSE(TlsContext::server(one().certificatePem, "", ""));
  EXPECT_FALSE(TlsContext::client("-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n"));
}

TEST(Tls, AnswersAClientThatSpeaksPlainlyInItsOwnWay) {
  using namespace std::string_literals;
  const auto frameOfLength22 = "\x16\0\0\0what of 22 bytes begins"s;
  for (const std::string& plain : {"hello"s, frameOfLength22}) {
    MemoryLink link;
    End server(serverOf(one()).secure(link.takeServer()));
    End client(link.takeClient());
    client.transport->send(plain);
    link.settle();
    EXPECT_EQ(client.heard, "TLS only");
    EXPECT_EQ(client.closed, 1);
    EXPECT_EQ(server.heard, "");
    EXPECT_EQ(server.reason, "TLS: the client does not speak TLS");
  }
}

TEST(Tls, SaysThatTheServerSpeaksPlainly) {
  MemoryLink link;
  End server(link.takeServer());
  End client(clientOf(one()).secure(link.takeClient()));
  client.transport->send("my token");
  server.transport->send("what was that?");
  link.settle();
  EXPECT_EQ(client.heard, "");
  EXPECT_THAT(client.reason, HasSubstr("the server does not speak TLS"));
  EXPECT_THAT(server.heard, testing::Not(HasSubstr("my token")));
}

TEST(Tls, SaysThatTheHandshakeWasCutShort) {
  MemoryLink link;
  End client(clientOf(one()).secure(link.takeClient()));
  link.cut("cable");
  EXPECT_EQ(client.reason, "cut short during the TLS handshake: cable");
}

/// The first flight of a client that would like `version` and nothing newer.
std::string clientHelloOf(int version) {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), version);
  SSL_CTX_set_max_proto_version(context.get(), version);
  const std::unique_ptr<SSL, decltype(&SSL_free)> ssl(SSL_new(context.get()), &SSL_free);
  BIO* out = BIO_new(BIO_s_mem());
  SSL_set_bio(ssl.get(), BIO_new(BIO_s_mem()), out);
  SSL_connect(ssl.get());
  char* data = nullptr;
  const long size = BIO_get_mem_data(out, &data);
  return {data, static_cast<std::size_t>(size)};
}

TEST(Tls, IsSpokenInNoOlderVersion) {
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION, TLS1_2_VERSION}) {
    MemoryLink link;
    End server(serverOf(one()).secure(link.takeServer()));
    End client(link.takeClient());
    client.transport->send(clientHelloOf(version));
    link.settle();
    EXPECT_EQ(server.reason, "TLS: the client does not speak TLS 1.3") << version;
    EXPECT_EQ(client.closed, 1);
  }
}

TEST(Tls, NoticesADamagedRecord) {
  // Between two lines, so that what goes from one end to the other can be changed.
  MemoryLink near, far;
  End client(clientOf(one()).secure(near.takeClient()));
  End server(serverOf(one()).secure(far.takeServer()));
  End atClient(near.takeServer()), atServer(far.takeClient());
  bool damage = false;
  atClient.then = [&] {
    std::string bytes = std::exchange(atClient.heard, {});
    if (damage) bytes.back() = static_cast<char>(bytes.back() ^ 1);
    atServer.transport->send(std::move(bytes));
  };
  atServer.then = [&] { atClient.transport->send(std::exchange(atServer.heard, {})); };
  const auto settle = [&] {
    while (near.pump() || far.pump()) {
    }
  };
  client.transport->send("whole");
  settle();
  ASSERT_EQ(server.heard, "whole");
  damage = true;
  client.transport->send("damaged");
  settle();
  EXPECT_EQ(server.heard, "whole");
  EXPECT_THAT(server.reason, testing::StartsWith("TLS: the client failed"));
}

TEST(Tls, OverTcpShowsWhatTheSystemHasNotTaken) {
  EventLoop loop;
  const auto serveUntil = [&](const std::function<bool()>& condition) {
    const Timer look = loop.every(std::chrono::milliseconds(1), [&] {
      if (condition()) loop.stop();
    });
    const Timer limit = loop.after(std::chrono::seconds(30), [&] { loop.stop(); });
    loop.run();
    ASSERT_TRUE(condition()) << "not within 30 s";
  };
  std::unique_ptr<Transport> accepted, connected;
  const auto listener = TcpListener::open(loop, {"127.0.0.1", 0}, [&](auto t) { accepted = std::move(t); });
  ASSERT_TRUE(listener);
  const TcpConnector connector(loop, (*listener)->local(), [&](auto result) { connected = std::move(*result); });
  serveUntil([&] { return accepted && connected; });
  End server(serverOf(one()).secure(std::move(accepted)));
  End client(clientOf(one()).secure(std::move(connected)));
  client.transport->send("go");
  serveUntil([&] { return server.heard == "go"; });

  constexpr std::size_t kSize = 1U << 20;
  server.transport->send(std::string(kSize, 'x'));
  EXPECT_GT(server.transport->backlog(), kSize) << "nothing hides between TLS and TCP";
  serveUntil([&] { return client.heard.size() == kSize && server.drained > 0; });
  EXPECT_EQ(server.transport->backlog(), 0U);
}

}  // namespace
}  // namespace haptics::tls_test
