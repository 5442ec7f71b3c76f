#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "haptic_server/net/adoption_tracker.h"
#include "haptic_server/net/scene_messages.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics::session_live_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using Kind = v1::Envelope;

class SessionLive : public ::testing::Test, public SessionWorld {
 protected:
  SessionLive() {
    edit(test::edit(add("a")));
    join();
  }
  void offer(std::uint64_t tick) {
    TelemetrySample sample;
    sample.tick = tick;
    session.offerTelemetry(sample);
  }
  std::vector<std::uint64_t> ticks() const {
    std::vector<std::uint64_t> ticks;
    for (const auto& envelope : client.all(Kind::kTelemetry)) ticks.push_back(envelope.telemetry().tick());
    return ticks;
  }
};

TEST_F(SessionLive, SendsNoTelemetryUnasked) {
  offer(1);
  link.settle();
  EXPECT_THAT(ticks(), ElementsAre());
}

TEST_F(SessionLive, SendsOnlyTheNewestSampleToALineThatWasBusy) {
  client.subscribe(1000);
  link.settle();
  offer(1);
  for (std::uint64_t tick = 2; tick <= 100; ++tick) {
    time_ns += kMillisecond_ns;
    offer(tick);
  }
  link.settle();
  EXPECT_THAT(ticks(), ElementsAre(1, 100));
}

TEST_F(SessionLive, SendsDatagramsWhereThatPathIsOpenHoweverBusyTheLine) {
  client.subscribe(1000, true);
  link.settle();
  offer(1);
  link.settle();
  EXPECT_THAT(ticks(), ElementsAre(1)) << "no path yet";
  datagramPathOpen = true;
  serverEnd->send(std::string(4, '\0'));  // waits: nothing is pumped from here on
  for (std::uint64_t tick = 2; tick <= 4; ++tick) {
    time_ns += kMillisecond_ns;
    offer(tick);
  }
  ASSERT_EQ(datagrams.size(), 3U);
  EXPECT_EQ(datagrams.back().tick(), 4U);
}

TEST_F(SessionLive, SendsOneSampleAnHourAtLeast) {
  client.subscribe(std::numeric_limits<double>::denorm_min());
  link.settle();
  offer(1);
  time_ns += static_cast<std::uint64_t>(TelemetrySlot::kLongestPeriod_s * 1e9);
  offer(2);
  link.settle();
  EXPECT_THAT(ticks(), ElementsAre(1, 2));
}

TEST(SceneMessages, ARefusalInWordsThatAreNotUtf8CanBeRead) {
  v1::EditReply reply, read;
  toWire(Error{"K\xf6rper.3mf", "names an object of \"\xe4.model\""}, kMaxFrameBytes, reply);
  ASSERT_TRUE(read.ParseFromString(reply.SerializeAsString()));
  EXPECT_EQ(read.rejected().field(), "K\\xf6rper.3mf");
  EXPECT_EQ(read.rejected().reason(), "names an object of \"\\xe4.model\"");
}

TEST_F(SessionLive, SendsNoDatagramsUnasked) {
  datagramPathOpen = true;
  client.subscribe(1000);
  link.settle();
  offer(1);
  link.settle();
  EXPECT_TRUE(datagrams.empty());
  EXPECT_THAT(ticks(), ElementsAre(1));
}

TEST_F(SessionLive, KeepsToTheSubscribedRate) {
  for (const double rate_Hz : {60.0, 250.0, 5000.0}) {
    client.subscribe(rate_Hz);
    client.got.clear();
    for (std::uint64_t tick = 0; tick < 1000; ++tick) {
      offer(tick);
      pass(kMillisecond_ns, kMillisecond_ns);
      if (tick % 500 == 0) client.heartbeat();
    }
    EXPECT_NEAR(static_cast<double>(ticks().size()), std::min(rate_Hz, 1000.0), 2);
  }
  client.subscribe(0);
  client.got.clear();
  link.settle();
  offer(1);
  link.settle();
  EXPECT_THAT(ticks(), ElementsAre());
}

TEST_F(SessionLive, RefusesARateThatIsNone) {
  client.subscribe(std::numeric_limits<double>::quiet_NaN());
  link.settle();
  EXPECT_EQ(client.refusal().field(), "subscribe.rate_hz");
}

TEST_F(SessionLive, AnswersAnEditThenSaysFromWhichTickItIsFelt) {
  client.moveObject(1, "a", 0.5);
  link.settle();
  const auto replies = client.all(Kind::kEditReply);
  ASSERT_EQ(replies.size(), 1U);
  const v1::Accepted& accepted = replies[0].edit_reply().accepted();
  EXPECT_EQ(accepted.revision(), 2U);
  EXPECT_EQ(accepted.root(), history()->version.root().asBytes());
  EXPECT_EQ(accepted.object(0).pose().position().x(), 0.5);
  EXPECT_EQ(client.count(Kind::kCommit), 1U);
  EXPECT_EQ(client.count(Kind::kEditLive), 0U);

  session.adopted(1, 100);
  link.settle();
  EXPECT_EQ(client.count(Kind::kEditLive), 0U);
  session.adopted(2, 150);
  session.adopted(2, 600);  // the same revision published again
  link.settle();
  ASSERT_EQ(client.count(Kind::kEditLive), 1U);
  EXPECT_EQ(client.got.back().edit_live().client_seq(), 1U);
  EXPECT_EQ(client.got.back().edit_live().revision(), 2U);
  EXPECT_EQ(client.got.back().edit_live().tick(), 150U);
}

TEST_F(SessionLive, SaysWithEachHeartbeatThatAnEditIsNotForgotten) {
  decides = false;
  client.moveObject(1, "a", 0.5, true);
  client.moveObject(2, "a", 0.5);
  link.settle();
  client.got.clear();
  time_ns += ServerSession::kHeartbeat_ns;
  session.poll();
  link.settle();
  ASSERT_EQ(client.count(Kind::kEditProgress), 1U);
  EXPECT_EQ(client.all(Kind::kEditProgress)[0].edit_progress().client_seq(), 1U);
  session.editDecided(1, Error{"", "no"});
  link.settle();
  client.got.clear();
  time_ns += ServerSession::kHeartbeat_ns;
  session.poll();
  link.settle();
  EXPECT_EQ(client.count(Kind::kEditProgress), 0U);
}

TEST_F(SessionLive, SaysHowFarAnEditIsToWhoAskedForIt) {
  client.moveObject(1, "a", 0.5);
  client.moveObject(2, "a", 0.5, true);
  link.settle();
  const auto told = client.all(Kind::kEditProgress);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].edit_progress().client_seq(), 2U);
  EXPECT_EQ(told[0].edit_progress().stage(), v1::EditProgress::STAGE_BUILDING);
  EXPECT_EQ(told[0].edit_progress().share(), 0.5);
  EXPECT_EQ(client.count(Kind::kEditReply), 2U);
}

TEST_F(SessionLive, RejectionsNameTheField) {
  client.moveObject(1, "b", 0);
  client.moveObject(2, "a", std::numeric_limits<double>::infinity());
  link.settle();
  const auto replies = client.all(Kind::kEditReply);
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[0].edit_reply().rejected().field(), "operations[0].set_pose.object");
  EXPECT_EQ(replies[1].edit_reply().client_seq(), 2U);
  EXPECT_THAT(replies[1].edit_reply().rejected().field(),
              ::testing::StartsWith("operations[0].set_pose.pose.position"));
  EXPECT_FALSE(client.closed);
}

TEST_F(SessionLive, AConflictShowsTheObjectAsItStands) {
  v1::Envelope envelope;
  envelope.mutable_edit_request()->set_client_seq(1);
  v1::Transaction& transaction = *envelope.mutable_edit_request()->mutable_transaction();
  transaction.add_preconditions()->mutable_object()->set_name("a");
  transaction.mutable_preconditions(0)->set_expected_revision(9);
  transaction.add_operations()->mutable_remove()->mutable_object()->set_name("a");
  client.send(envelope);
  link.settle();
  ASSERT_TRUE(client.got.back().edit_reply().has_conflict());
  EXPECT_EQ(client.got.back().edit_reply().conflict().current(0).name(), "a");
}

TEST_F(SessionLive, EditsBeyondTheRateComeTooEarlyAndLaterOnesNot) {
  const auto burst = static_cast<std::uint64_t>(SessionLimits{}.editBurst);
  for (std::uint64_t seq = 1; seq <= burst + 10; ++seq) client.moveObject(seq, "a", 0);
  link.settle();
  EXPECT_EQ(history()->version.revision(), 1 + burst);
  EXPECT_EQ(client.all(Kind::kEditReply).back().edit_reply().rejected().field(), "rate");
  EXPECT_EQ(client.all(Kind::kEditReply).back().edit_reply().rejected().retry_after_ms(), EditGate::kRetryAfter_ms);
  pass(kSecond_ns);
  client.moveObject(burst + 11, "a", 0);
  link.settle();
  EXPECT_EQ(history()->version.revision(), 1 + burst) << "may not overtake those before it";
  for (std::uint64_t seq = burst + 1; seq <= burst + 11; ++seq) client.moveObject(seq, "a", 0);
  link.settle();
  EXPECT_EQ(history()->version.revision(), 12 + burst);
}

TEST_F(SessionLive, NoEditOvertakesOneForWhichThereWasNoRoom) {
  builderIsFull = true;
  client.moveObject(1, "a", 1);
  link.settle();
  EXPECT_EQ(client.got.back().edit_reply().rejected().field(), "busy");
  EXPECT_GT(client.got.back().edit_reply().rejected().retry_after_ms(), 0U);
  builderIsFull = false;
  client.moveObject(2, "a", 2);
  link.settle();
  EXPECT_EQ(client.got.back().edit_reply().client_seq(), 2U);
  EXPECT_EQ(client.got.back().edit_reply().rejected().field(), "busy");
  EXPECT_EQ(history()->version.revision(), 1U);
  client.moveObject(1, "a", 1);
  client.moveObject(2, "a", 2);
  link.settle();
  EXPECT_EQ(history()->version.revision(), 3U);
  EXPECT_EQ(history()->version.find("a")->pose.position.x, 2);
}

/// Revisions and ids of one epoch mean other things in the next.
TEST_F(SessionLive, AnEditThatRestsOnALostStateIsInConflict) {
  const auto send = [&](std::uint64_t seq, const auto& change) {
    v1::Envelope envelope;
    v1::EditRequest& request = *envelope.mutable_edit_request();
    request.set_client_seq(seq);
    request.set_epoch(history()->epoch + 1);
    request.mutable_transaction()->add_operations()->mutable_set_material()->mutable_object()->set_name("a");
    request.mutable_transaction()
        ->mutable_operations(0)
        ->mutable_set_material()
        ->mutable_material()
        ->set_stiffness_n_per_m(500);
    change(request);
    client.send(envelope);
    link.settle();
    return client.all(Kind::kEditReply).back().edit_reply();
  };
  const auto expectingRevision = [](v1::EditRequest& request) {
    v1::Precondition& precondition = *request.mutable_transaction()->add_preconditions();
    precondition.mutable_object()->set_name("a");
    precondition.set_expected_revision(1);
  };
  const auto byId = [this](v1::EditRequest& request) {
    auto& object = *request.mutable_transaction()->mutable_operations(0)->mutable_set_material()->mutable_object();
    object.set_id(history()->version.find("a")->id);
  };
  EXPECT_TRUE(send(1, expectingRevision).has_conflict());
  EXPECT_TRUE(send(2, byId).has_conflict());
  EXPECT_TRUE(send(3, [](v1::EditRequest&) {}).has_accepted()) << "a name means the same";
  EXPECT_TRUE(send(4, [&](v1::EditRequest& request) {
                request.set_epoch(history()->epoch);
                byId(request);
              }).has_accepted());
}

TEST_F(SessionLive, HeartbeatsSayWhatTheServoFeels) {
  session.adopted(1, 100);
  pass(kSecond_ns);
  const auto beats = client.all(Kind::kHeartbeat);
  ASSERT_FALSE(beats.empty());
  EXPECT_EQ(beats.back().heartbeat().adopted_revision(), 1U);
  EXPECT_EQ(beats.back().heartbeat().adoption_tick(), 100U);
}

TEST_F(SessionLive, AReaderThatStopsCostsBoundedMemoryUntilItIsDisconnected) {
  std::size_t largest = 0;
  Transaction all;
  for (int i = 0; i < 40; ++i) all.operations.push_back(add(std::string(50, 'n').append(std::to_string(i))));
  edit(all);
  for (std::size_t i = 0; i < kRememberedEdits + 200 && refusals.empty(); ++i) {
    Transaction moves;
    for (const auto& object : history()->version.objects()) moves.operations.push_back(moveTo(object->name, {1, 0, 0}));
    edit(moves);
    client.subscribe(1000);
    offer(i);
    largest = std::max(largest, serverEnd->backlog());
  }
  EXPECT_LT(largest, SessionLimits{}.sendAhead_bytes + (64U << 10));
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_THAT(refusals[0], ::testing::HasSubstr("too slowly"));
}

/// A line on which the other end is alive and takes nothing.
class UnreadLine final : public Transport {
 public:
  void start(Events events) override { events_ = std::move(events); }
  void send(std::string bytes) override { unread += bytes; }
  [[nodiscard]] std::size_t backlog() const noexcept override { return unread.size(); }
  void close(const std::string&) override {}
  [[nodiscard]] std::string peer() const override { return "nobody"; }
  void receive(const v1::Envelope& envelope) {
    std::string frame;
    ASSERT_TRUE(appendFrame(frame, envelope));
    events_.received(frame);
  }
  std::string unread;

 private:
  Events events_;
};

TEST_F(SessionLive, AClientThatIsAliveAndTakesNothingIsDisconnected) {
  UnreadLine line;
  ServerSession idle(line, *this, identity);
  idle.start();
  v1::Envelope hello, alive;
  hello.set_protocol_version(kProtocolVersion);
  hello.mutable_hello()->set_session(kClientSession + 1);
  alive.set_protocol_version(kProtocolVersion);
  alive.mutable_heartbeat();
  line.receive(hello);
  const auto beats = [&](int count) {
    for (int second = 0; second < count; ++second) {
      line.receive(alive);
      time_ns += kSecond_ns;
      idle.poll();
    }
  };
  beats(9);
  line.unread.pop_back();
  beats(10);
  EXPECT_THAT(refusals, ::testing::IsEmpty()) << "it has taken something";
  beats(1);
  EXPECT_THAT(refusals, ::testing::ElementsAre(::testing::HasSubstr("reads too slowly: for 10 s")));
}

TEST_F(SessionLive, AClientThatAsksFasterThanItReadsIsDisconnected) {
  v1::Envelope request;
  request.set_protocol_version(kProtocolVersion);
  request.mutable_status_request();
  std::string requests;
  for (int i = 0; i < 100'000; ++i) ASSERT_TRUE(appendFrame(requests, request));
  client.sendBytes(requests);
  std::size_t largest = 0;
  // The line carries as much either way, and an answer is larger than its request.
  while (refusals.empty() && link.pump(10'000)) largest = std::max(largest, serverEnd->backlog());
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_GT(largest, SessionLimits{}.backlog_bytes / 2);
  EXPECT_LT(largest, SessionLimits{}.backlog_bytes + (256U << 10));
}

TEST_F(SessionLive, TellsTimeAndStatus) {
  v1::Envelope probe;
  probe.mutable_clock_probe()->set_client_send_ns(17);
  client.send(probe);
  v1::Envelope request;
  request.mutable_status_request();
  client.send(request);
  link.settle();
  const v1::ClockReply reply = client.all(Kind::kClockReply).at(0).clock_reply();
  EXPECT_EQ(reply.client_send_ns(), 17U);
  EXPECT_NEAR(static_cast<double>(reply.server_receive_ns()), static_cast<double>(time_ns), 1000);
  EXPECT_GT(reply.server_send_ns(), reply.server_receive_ns());
  const v1::Status status = client.all(Kind::kStatus).at(0).status();
  EXPECT_EQ(status.ticks(), 42U);
  EXPECT_EQ(status.revision(), 1U);
  EXPECT_EQ(status.root(), history()->version.root().asBytes());
}

class SessionHand : public SessionLive {
 protected:
  [[nodiscard]] Result<void> leadHand(std::size_t /*hand*/, bool lead) override {
    if (lead && otherLeads) return haptics::refused("lead_hand", "the hand is led by other");
    leads = lead;
    return {};
  }
  void commandHand(std::size_t /*hand*/, const HandCommand& command) override { commands.push_back(command); }
  [[nodiscard]] Result<void> moveWorkspace(std::size_t hand, const WorkspaceCommand& command) override {
    if (hand > 0) return SessionLive::moveWorkspace(hand, command);
    moves.push_back(command);
    return {};
  }
  void move(const v1::SetWorkspace& message) {
    v1::Envelope envelope;
    *envelope.mutable_set_workspace() = message;
    client.send(envelope);
    link.settle();
  }
  [[nodiscard]] Result<void> addWrench(std::size_t hand, const Wrench& wrench) override {
    if (hand > 0) return SessionLive::addWrench(hand, wrench);
    wrenches.push_back(wrench);
    return {};
  }
  void add(const v1::AddWrench& message) {
    v1::Envelope envelope;
    *envelope.mutable_add_wrench() = message;
    client.send(envelope);
    link.settle();
  }
  [[nodiscard]] std::optional<Leader> handLeader(std::size_t /*hand*/) const override {
    if (otherLeads) return Leader{"other", session.id() + 1};
    return leads ? std::optional(Leader{session.name(), session.id()}) : std::nullopt;
  }
  v1::HandLeader ask(bool lead) {
    v1::Envelope envelope;
    envelope.mutable_lead_hand()->set_lead(lead);
    client.send(envelope);
    link.settle();
    return client.all(Kind::kHandLeader).back().hand_leader();
  }
  void command(double x, double normal_z, double press_N) {
    v1::Envelope envelope;
    envelope.mutable_hand_target()->mutable_position()->set_x(x);
    envelope.mutable_hand_target()->mutable_normal()->set_z(normal_z);
    envelope.mutable_hand_target()->set_press_n(press_N);
    client.send(envelope);
    link.settle();
  }

  bool leads = false, otherLeads = false;
  std::vector<HandCommand> commands;
  std::vector<WorkspaceCommand> moves;
  std::vector<Wrench> wrenches;
};

TEST_F(SessionHand, TakesWhatIsToBeAddedToItsForce) {
  v1::AddWrench message;
  message.mutable_force_n()->set_x(-100);
  message.mutable_torque_nm()->set_z(10);
  add(message);
  add({});
  ASSERT_EQ(wrenches.size(), 2U);
  EXPECT_EQ(wrenches[0], (Wrench{{-100, 0, 0}, {0, 0, 10}}));
  EXPECT_EQ(wrenches[1], Wrench{});
  message.mutable_force_n()->set_y(std::numeric_limits<double>::quiet_NaN());
  add(message);
  EXPECT_EQ(client.refusal().field(), "add_wrench.force_N.y");
  EXPECT_EQ(wrenches.size(), 2U);
}

TEST_F(SessionHand, RefusesATorqueThatNoHandBears) {
  v1::AddWrench message;
  message.mutable_torque_nm()->set_y(10.1);
  add(message);
  EXPECT_EQ(client.refusal().field(), "add_wrench.torque_Nm.y");
}

TEST_F(SessionHand, RefusesToAddToAHandThatIsNotThere) {
  v1::AddWrench message;
  message.set_hand(1);
  add(message);
  EXPECT_EQ(client.refusal().field(), "add_wrench.hand");
}

TEST_F(SessionHand, ItsWorkspaceIsMovedByWhatIsGivenAlone) {
  v1::SetWorkspace message;
  message.mutable_offset()->set_x(0.1);
  message.set_clutch_buttons(0x80000001);
  message.set_grasp_buttons(2);
  message.set_mark_buttons(4);
  message.set_next_tool_buttons(8);
  message.mutable_bubble()->mutable_centre()->set_z(0.1);
  message.mutable_bubble()->set_radius_m(0.05);
  move(message);
  message.Clear();
  message.set_scale(2);
  message.mutable_rotation()->set_w(1.0005);
  move(message);
  ASSERT_EQ(moves.size(), 2U);
  EXPECT_EQ(moves[0].offset, Vec3(0.1, 0, 0));
  EXPECT_EQ(moves[0].clutchButtons, 0x80000001);
  EXPECT_EQ(moves[0].graspButtons, 2U);
  EXPECT_EQ(moves[0].markButtons, 4U);
  EXPECT_EQ(moves[0].nextToolButtons, 8U);
  ASSERT_TRUE(moves[0].bubble);
  EXPECT_EQ(moves[0].bubble->centre, Vec3(0, 0, 0.1));
  EXPECT_EQ(moves[0].bubble->radius_m, 0.05);
  EXPECT_FALSE(moves[0].scale || moves[0].rotation);
  EXPECT_EQ(moves[1].scale, 2);
  EXPECT_EQ(moves[1].rotation, Quat(1, 0, 0, 0));
  EXPECT_FALSE(moves[1].offset || moves[1].clutchButtons || moves[1].graspButtons || moves[1].markButtons);
}

TEST_F(SessionHand, RefusesAWorkspaceThatIsNone) {
  v1::SetWorkspace message;
  message.set_scale(std::numeric_limits<double>::quiet_NaN());
  move(message);
  EXPECT_EQ(client.refusal().field(), "set_workspace.scale");
  EXPECT_TRUE(moves.empty());
}

TEST_F(SessionHand, RefusesABubbleOfNoSize) {
  v1::SetWorkspace message;
  message.mutable_bubble()->set_radius_m(0);
  move(message);
  EXPECT_EQ(moves.size(), 1U) << "0 takes it away";
  message.mutable_bubble()->set_radius_m(0.001);
  move(message);
  EXPECT_EQ(client.refusal().field(), "set_workspace.bubble.radius_m");
}

TEST_F(SessionHand, RefusesToMoveTheWorkspaceOfAHandThatIsNotThere) {
  v1::SetWorkspace message;
  message.set_hand(1);
  move(message);
  EXPECT_EQ(client.refusal().field(), "set_workspace.hand");
}

TEST_F(SessionHand, IsLedByAClientThatAsks) {
  EXPECT_TRUE(ask(true).you());
  command(0.1, 1, 2);
  command(0.2, 0, 0);
  ASSERT_EQ(commands.size(), 2U);
  EXPECT_EQ(commands[0].position, Vec3(0.1, 0, 0));
  EXPECT_EQ(commands[0].normal, Vec3(0, 0, 1));
  EXPECT_EQ(commands[0].press_N, 2);
  EXPECT_TRUE(commands[1].leads);
  EXPECT_EQ(commands[1].press_N, 0);
  EXPECT_FALSE(ask(false).led());
}

TEST_F(SessionHand, IsRefusedNamingItsLeaderAndFollowedFromThenOn) {
  session.handLeaderChanged(0);
  link.settle();
  EXPECT_EQ(client.count(Kind::kHandLeader), 0U) << "nobody asked";
  otherLeads = true;
  const v1::HandLeader refused = ask(true);
  EXPECT_EQ(refused.refused(), "lead_hand: the hand is led by other");
  EXPECT_EQ(refused.client_name(), "other");
  EXPECT_FALSE(refused.you());
  otherLeads = false;
  session.handLeaderChanged(0);
  link.settle();
  EXPECT_FALSE(client.all(Kind::kHandLeader).back().hand_leader().led());
}

TEST_F(SessionHand, RefusesTargetsThatAreNone) {
  ask(true);
  command(std::numeric_limits<double>::quiet_NaN(), 1, 1);
  EXPECT_THAT(client.refusal().field(), ::testing::StartsWith("hand_target.position"));
  EXPECT_TRUE(commands.empty());
}

TEST_F(SessionHand, OpensItsGripperAsFarAsThereAreAngles) {
  ask(true);
  const auto open = [this](double angle_rad) {
    v1::Envelope envelope;
    envelope.mutable_hand_target()->set_gripper_rad(angle_rad);
    client.send(envelope);
    link.settle();
  };
  open(0.4);
  command(0, 0, 0);
  ASSERT_EQ(commands.size(), 2U);
  EXPECT_EQ(commands[0].gripper_rad, 0.4);
  EXPECT_EQ(commands[1].gripper_rad, std::nullopt);
  open(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(client.refusal().field(), "hand_target.gripper_rad");
  EXPECT_EQ(commands.size(), 2U);
}

TEST_F(SessionHand, RefusesAPressWithoutANormal) {
  ask(true);
  command(0, 0.5, 1);
  EXPECT_THAT(client.refusal().field(), ::testing::StartsWith("hand_target.normal"));
}

TEST(AdoptionTracker, RemembersAdoptionsForEditsWhoseAcceptanceComesLate) {
  AdoptionTracker watch;
  watch.adopted(1, 10);
  watch.adopted(2, 20);
  watch.adopted(4, 40);
  watch.accepted(7, 2);
  watch.accepted(8, 3);
  watch.accepted(9, 5);
  auto live = watch.take();
  ASSERT_EQ(live.size(), 2U);
  EXPECT_EQ(live[0].tick(), 20U);
  EXPECT_EQ(live[1].tick(), 40U) << "revision 3 was skipped by the servo";
  EXPECT_TRUE(watch.take().empty());
  watch.adopted(5, 50);
  EXPECT_EQ(watch.take().at(0).client_seq(), 9U);
}

}  // namespace
}  // namespace haptics::session_live_test
