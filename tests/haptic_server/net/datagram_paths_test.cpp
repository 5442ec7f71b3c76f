#include "haptic_server/net/datagram_paths.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/wire/udp.h"

namespace haptics::datagram_paths_test {
namespace {

constexpr std::uint64_t kConnection = 3, kOther = 4;
constexpr std::uint64_t kNow_ns = 1'000'000'000'000;
const Endpoint kClient{"10.0.0.2", 5000};

class DatagramPathsTest : public testing::Test {
 protected:
  void knock(const std::string& with, const Endpoint& from = kClient, std::uint64_t now_ns = kNow_ns) {
    v1::Datagram datagram;
    datagram.set_cookie(with);
    hear(datagram.SerializeAsString(), from, now_ns);
  }
  void hear(const std::string& bytes, const Endpoint& from = kClient, std::uint64_t now_ns = kNow_ns) {
    paths.received(bytes, from, now_ns);
  }
  static v1::Telemetry sample(std::uint64_t tick) {
    v1::Telemetry telemetry;
    telemetry.set_tick(tick);
    return telemetry;
  }

  std::vector<std::pair<v1::Datagram, Endpoint>> sent;
  void aim(std::uint64_t number, std::uint32_t hand = 0) {
    v1::Datagram datagram;
    datagram.set_cookie(cookie);
    datagram.mutable_hand_target()->set_hand(hand);
    datagram.mutable_hand_target()->set_number(number);
    hear(datagram.SerializeAsString());
  }

  std::vector<v1::HandTarget> targets;
  DatagramPaths paths{[this](std::span<const char> bytes, const Endpoint& to) {
                        v1::Datagram datagram;
                        EXPECT_TRUE(datagram.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
                        sent.emplace_back(std::move(datagram), to);
                      },
                      [this](std::uint64_t connection, const v1::HandTarget& target) {
                        EXPECT_EQ(connection, kConnection);
                        targets.push_back(target);
                      }};
  std::string cookie = paths.add(kConnection, kClient.host);
};

TEST_F(DatagramPathsTest, SendNothingToWhoHasNotKnocked) {
  EXPECT_FALSE(paths.send(kConnection, sample(1), kNow_ns));
  EXPECT_TRUE(sent.empty());
}

TEST_F(DatagramPathsTest, AnswerAKnockAndThenCarryTelemetry) {
  knock(cookie);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].first.cookie(), cookie);
  EXPECT_FALSE(sent[0].first.has_telemetry());
  EXPECT_EQ(sent[0].second, kClient);

  EXPECT_TRUE(paths.send(kConnection, sample(7), kNow_ns));
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent[1].first.cookie(), cookie);
  EXPECT_EQ(sent[1].first.telemetry().tick(), 7U);
  EXPECT_EQ(sent[1].second, kClient);
  EXPECT_FALSE(paths.send(kOther, sample(8), kNow_ns)) << "each path is one connection's";
  EXPECT_EQ(paths.forged(), 0U);
}

TEST_F(DatagramPathsTest, PassTheNewestTargetOfEachHandOn) {
  for (const std::uint64_t number : {1, 2, 4, 3, 4, 5}) aim(number);
  ASSERT_EQ(targets.size(), 4U) << "3 came too late, and 4 twice";
  EXPECT_EQ(targets.back().number(), 5U);
  aim(1, 1);
  ASSERT_EQ(targets.size(), 5U) << "the second hand's count is its own";
  EXPECT_EQ(targets.back().hand(), 1U);
  aim(9, 2);
  EXPECT_EQ(targets.size(), 5U) << "there is no third hand";
  EXPECT_TRUE(sent.empty()) << "none is answered";
}

TEST_F(DatagramPathsTest, CloseWhenNothingIsHeard) {
  knock(cookie);
  EXPECT_TRUE(paths.send(kConnection, sample(1), kNow_ns + DatagramPaths::kOpenFor_ns));
  EXPECT_FALSE(paths.send(kConnection, sample(2), kNow_ns + DatagramPaths::kOpenFor_ns + 1));
}

TEST_F(DatagramPathsTest, FollowAClientToItsNewPort) {
  knock(cookie);
  knock(cookie, {kClient.host, 6000});
  ASSERT_TRUE(paths.send(kConnection, sample(1), kNow_ns));
  EXPECT_EQ(sent.back().second.port, 6000);
}

TEST_F(DatagramPathsTest, LeadNowhereButToTheConnectionsHost) {
  knock(cookie, {"10.0.0.66", 5000});
  EXPECT_EQ(paths.forged(), 1U);
  EXPECT_FALSE(paths.send(kConnection, sample(1), kNow_ns));
  EXPECT_TRUE(sent.empty());
}

TEST_F(DatagramPathsTest, IgnoreAndCountWhatIsForged) {
  std::string guess = cookie;
  guess[0] = static_cast<char>(guess[0] ^ 1);
  v1::Datagram telemetry;
  telemetry.set_cookie(cookie);
  telemetry.mutable_telemetry()->set_tick(5);
  v1::Datagram huge;
  huge.set_cookie(cookie + std::string(kMaxDatagramBytes, 'x'));
  knock(guess);
  knock("");
  hear("");
  hear("garbage");
  hear(telemetry.SerializeAsString());
  hear(huge.SerializeAsString());
  EXPECT_EQ(paths.forged(), 6U);
  EXPECT_TRUE(sent.empty());
  EXPECT_FALSE(paths.send(kConnection, sample(1), kNow_ns));
}

TEST_F(DatagramPathsTest, AreForgottenWithTheirConnection) {
  paths.remove(kConnection);
  paths.remove(kConnection);
  knock(cookie);
  EXPECT_EQ(paths.forged(), 1U);
  EXPECT_FALSE(paths.send(kConnection, sample(1), kNow_ns));
}

TEST_F(DatagramPathsTest, HaveCookiesThatDiffer) {
  const std::string other = paths.add(kOther, kClient.host);
  EXPECT_EQ(cookie.size(), DatagramPaths::kCookieBytes);
  EXPECT_NE(cookie, other);
  EXPECT_NE(paths.add(kConnection, kClient.host), cookie);
  knock(cookie);
  EXPECT_EQ(paths.forged(), 1U) << "the cookie before";
}

TEST_F(DatagramPathsTest, LeaveWhatIsTooLargeToTheConnection) {
  knock(cookie);
  v1::Telemetry large = sample(1);
  for (int i = 0; i < 100; ++i) large.add_body()->mutable_pose()->mutable_position()->set_x(1);
  EXPECT_FALSE(paths.send(kConnection, large, kNow_ns));
}

}  // namespace
}  // namespace haptics::datagram_paths_test
