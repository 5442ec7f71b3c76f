#include <gmock/gmock.h>

#include "tests/graphics_client/mirror/fake_server.h"

// The lead of the simulated hand.
namespace haptics::session_hand_test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

class SessionHand : public testing::Test {
 protected:
  void SetUp() override { rig_.join(); }

  void answer(const std::string& leader, bool you, const std::string& refused = "") {
    v1::Envelope envelope;
    v1::HandLeader& message = *envelope.mutable_hand_leader();
    message.set_led(!leader.empty());
    message.set_client_name(leader);
    message.set_you(you);
    message.set_refused(refused);
    rig_.server.send(envelope);
    rig_.settle();
  }

  void lead() {
    rig_.client.leadHand(true, rig_.now_ns);
    rig_.settle();
    answer("test", true);
  }

  void command(double press_N) {
    rig_.client.commandHand(
        {.leads = true, .position = {1, 2, 3}, .normal = {0, 0, 1}, .press_N = press_N, .gripper_rad = 0.4},
        rig_.now_ns);
    rig_.settle();
  }

  std::vector<v1::Envelope> targets() const { return rig_.server.heard(v1::Envelope::kHandTarget); }

  SessionRig rig_;
};

TEST_F(SessionHand, IsLedOnceTheServerSaysSo) {
  rig_.client.leadHand(true, rig_.now_ns);
  rig_.settle();
  EXPECT_TRUE(rig_.server.heard(v1::Envelope::kLeadHand).at(0).lead_hand().lead());
  EXPECT_FALSE(rig_.view().hand.isSelf);
  command(1);
  EXPECT_TRUE(targets().empty());
  answer("test", true);
  EXPECT_TRUE(rig_.view().hand.isSelf);
  command(1.5);
  ASSERT_EQ(targets().size(), 1);
  EXPECT_EQ(targets()[0].hand_target().press_n(), 1.5);
  EXPECT_EQ(targets()[0].hand_target().position().y(), 2);
  EXPECT_EQ(targets()[0].hand_target().gripper_rad(), 0.4);
}

TEST_F(SessionHand, SaysWhoLeadsInstead) {
  rig_.client.leadHand(true, rig_.now_ns);
  answer("other", false, "lead_hand: the hand is led by other");
  EXPECT_EQ(rig_.view().hand.clientName, "other");
  EXPECT_EQ(rig_.view().hand.refused, "lead_hand: the hand is led by other");
  command(1);
  EXPECT_TRUE(targets().empty());
}

TEST_F(SessionHand, RepeatsItsTargetUntilItGivesTheLeadBack) {
  lead();
  command(1);
  rig_.advance(kSecond_ns);
  EXPECT_GE(targets().size(), 20);
  rig_.client.leadHand(false, rig_.now_ns);
  answer("", false);
  const std::size_t sent = targets().size();
  rig_.advance(kSecond_ns);
  EXPECT_EQ(targets().size(), sent);
}

TEST_F(SessionHand, IsLostWithTheConnection) {
  lead();
  command(1);
  rig_.cut();
  EXPECT_FALSE(rig_.view().hand.isSelf);
  rig_.connect();
  rig_.server.welcome(true);
  rig_.advance(kSecond_ns);
  EXPECT_TRUE(targets().empty());
}

TEST_F(SessionHand, IsFollowedFromTheWelcomeOn) {
  SessionRig rig({.session = 7, .clientName = "viewer", .token = "", .followsHand = true});
  rig.join();
  const auto asked = rig.server.heard(v1::Envelope::kLeadHand);
  ASSERT_EQ(asked.size(), 1);
  EXPECT_FALSE(asked[0].lead_hand().lead());
}

}  // namespace
}  // namespace haptics::session_hand_test
