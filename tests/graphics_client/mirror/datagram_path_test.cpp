#include "graphics_client/mirror/datagram_path.h"

#include <gmock/gmock.h>

#include "common/wire/udp.h"
#include "tests/graphics_client/mirror/fake_server.h"

namespace haptics::datagram_path_test {
namespace {

using testing::HasSubstr;

const Endpoint kServer{"10.0.0.1", 7654};
const std::string kCookie(16, 'c');

v1::Welcome offer() {
  v1::Welcome welcome;
  welcome.set_datagram_port(kServer.port);
  welcome.set_datagram_cookie(kCookie);
  return welcome;
}

std::string datagram(const std::string& cookie, std::uint64_t tick = 0) {
  v1::Datagram message;
  message.set_cookie(cookie);
  if (tick != 0) message.mutable_telemetry()->set_tick(tick);
  return message.SerializeAsString();
}

TEST(DatagramPath, KnocksUntilItOpens) {
  DatagramPath path;
  std::uint64_t now_ns = 1'000'000'000'000;
  EXPECT_FALSE(path.poll(now_ns)) << "nothing was offered";
  path.welcomed(offer(), kServer.host);
  const auto knock = path.poll(now_ns);
  ASSERT_TRUE(knock);
  EXPECT_EQ(knock->to, kServer);
  EXPECT_EQ(knock->bytes, datagram(kCookie));
  EXPECT_FALSE(path.poll(now_ns + DatagramPath::kKnock_ns - 1));
  EXPECT_TRUE(path.poll(now_ns + DatagramPath::kKnock_ns));
  EXPECT_FALSE(path.open());
  EXPECT_FALSE(path.take(knock->bytes, kServer, now_ns)) << "an answer holds no sample";
  EXPECT_TRUE(path.open());
}

TEST(DatagramPath, ClosesAfterASecondOfSilenceAndOpensAgain) {
  DatagramPath path;
  const std::uint64_t start_ns = 1'000'000'000'000;
  path.welcomed(offer(), kServer.host);
  ASSERT_TRUE(path.take(datagram(kCookie, 4), kServer, start_ns));
  (void)path.poll(start_ns + DatagramPath::kSilence_ns);
  EXPECT_TRUE(path.open());
  EXPECT_TRUE(path.poll(start_ns + DatagramPath::kSilence_ns + DatagramPath::kKnock_ns)) << "it goes on knocking";
  EXPECT_FALSE(path.open());
  (void)path.take(datagram(kCookie), kServer, start_ns + 3'000'000'000);
  EXPECT_TRUE(path.open());
}

TEST(DatagramPath, IgnoresAndCountsWhatIsForged) {
  DatagramPath path;
  path.welcomed(offer(), kServer.host);
  const std::string good = datagram(kCookie, 9);
  EXPECT_FALSE(path.take(datagram(std::string(16, 'd'), 9), kServer, 1));
  EXPECT_FALSE(path.take(datagram("", 9), kServer, 1));
  EXPECT_FALSE(path.take(good, {"10.0.0.66", kServer.port}, 1));
  EXPECT_FALSE(path.take(good, {kServer.host, 1}, 1));
  EXPECT_FALSE(path.take(std::string("garbage"), kServer, 1));
  EXPECT_FALSE(path.take(good + std::string(kMaxDatagramBytes, '\0'), kServer, 1));
  EXPECT_EQ(path.forged(), 6U);
  EXPECT_FALSE(path.open());
  EXPECT_TRUE(path.take(good, kServer, 1));
  EXPECT_EQ(path.forged(), 6U);
}

TEST(DatagramPath, TakesNothingOfAnEarlierConnection) {
  DatagramPath path;
  path.welcomed(offer(), kServer.host);
  ASSERT_TRUE(path.take(datagram(kCookie, 1), kServer, 1));
  path.connectionLost();
  EXPECT_FALSE(path.open());
  EXPECT_FALSE(path.take(datagram(kCookie, 2), kServer, 2));
  v1::Welcome none;
  path.welcomed(none, kServer.host);
  EXPECT_FALSE(path.offered());
  EXPECT_FALSE(path.take(datagram("", 3), {kServer.host, 0}, 3)) << "an empty cookie of port 0 is no offer";
}

/// A client that wants datagrams, and a server that offers them.
struct Rig : SessionRig {
  Rig()
      : SessionRig({.session = 77,
                    .clientName = "test",
                    .token = "",
                    .telemetryRate_Hz = 60,
                    .fetchAssets = true,
                    .datagrams = true}) {
    server.datagramPort = kServer.port;
    server.datagramCookie = kCookie;
    join();
  }
  [[nodiscard]] const Endpoint& from() {
    if (const auto knock = client.nextDatagram(now_ns)) from_ = knock->to;
    return from_;
  }
  [[nodiscard]] bool subscribedToDatagrams() const {
    return server.heard(v1::Envelope::kSubscribe).back().subscribe().datagrams();
  }

 private:
  Endpoint from_;
};

TEST(SessionOverDatagrams, SubscribesToThemOnceTheyComeThrough) {
  Rig rig;
  EXPECT_FALSE(rig.subscribedToDatagrams());
  EXPECT_THAT(rig.view().linkText, HasSubstr("telemetry over TCP"));
  const Endpoint server = rig.from();
  rig.client.datagramReceived(datagram(kCookie), server, rig.now_ns);
  rig.settle();
  EXPECT_TRUE(rig.subscribedToDatagrams());
  EXPECT_TRUE(rig.view().telemetryByDatagram);
  EXPECT_THAT(rig.view().linkText, HasSubstr("telemetry over UDP"));
  rig.client.datagramReceived(datagram(kCookie, 12), server, rig.now_ns);
  ASSERT_TRUE(rig.view().sample);
  EXPECT_EQ(rig.view().sample->tick, 12U);
  rig.client.datagramReceived(datagram(kCookie, 11), server, rig.now_ns);
  EXPECT_EQ(rig.view().sample->tick, 12U) << "never an older sample";
  EXPECT_EQ(rig.view().samplesReceived, 1U);
}

TEST(SessionOverDatagrams, GoesBackToTheConnectionWhenNoneComesForASecond) {
  Rig rig;
  rig.client.datagramReceived(datagram(kCookie), rig.from(), rig.now_ns);
  rig.now_ns += DatagramPath::kSilence_ns + 1;
  (void)rig.client.nextDatagram(rig.now_ns);
  rig.settle();
  EXPECT_FALSE(rig.subscribedToDatagrams());
  EXPECT_FALSE(rig.view().telemetryByDatagram);
  EXPECT_EQ(rig.view().datagramPathsLost, 1U);
  EXPECT_THAT(rig.view().linkText, HasSubstr("no datagram has come for 1 s"));
}

TEST(SessionOverDatagrams, DoesWithoutWhereNoneAreOffered) {
  Rig rig;
  rig.cut();
  rig.server.datagramPort = 0;
  rig.join();
  EXPECT_FALSE(rig.client.nextDatagram(rig.now_ns + 1'000'000'000));
  EXPECT_FALSE(rig.subscribedToDatagrams());
  EXPECT_THAT(rig.view().linkText, HasSubstr("offers no UDP"));
}

}  // namespace
}  // namespace haptics::datagram_path_test
