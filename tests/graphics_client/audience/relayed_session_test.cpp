#include "graphics_client/audience/relayed_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "graphics_client/mirror/client_session.h"
#include "tests/common/wire/memory_link.h"
#include "tests/graphics_client/audience/published_session.h"

namespace haptics::relayed_session_test {
namespace {

/// A client's session at a published one, over a line in memory.
class Relayed : public testing::Test {
 protected:
  void SetUp() override {
    published_.storeSnapshot();
    session_.emplace(
        published_.read().value(), [this](v1::Envelope& envelope) { send(envelope); },
        [this](const ContentHash& asset, std::uint64_t) { asked_.push_back(asset); });
    serverEnd_ = link_.takeServer();
    clientEnd_ = link_.takeClient();
    serverEnd_->start({.received =
                           [this](std::span<const char> bytes) {
                             decoder_.feed(bytes);
                             for (auto next = decoder_.next(); next && *next; next = decoder_.next()) {
                               EXPECT_TRUE(session_->fromClient(**next));
                             }
                           },
                       .drained = {},
                       .closed = {}});
    clientEnd_->start({.received = [this](std::span<const char> bytes) { client_.received(bytes, kNow_ns); },
                       .drained = {},
                       .closed = {}});
    client_.connected(*clientEnd_, kNow_ns);
    link_.settle();
  }

  void send(v1::Envelope& envelope) {
    envelope.set_protocol_version(kProtocolVersion);
    std::string frame;
    ASSERT_TRUE(appendFrame(frame, envelope));
    serverEnd_->send(std::move(frame));
  }

  [[nodiscard]] v1::LiveMessage live() const {
    v1::LiveMessage message;
    message.set_protocol_version(kProtocolVersion);
    message.set_epoch(published_.server.epoch);
    return message;
  }

  [[nodiscard]] v1::LiveMessage heartbeat(std::uint64_t revision) const {
    v1::LiveMessage message = live();
    message.mutable_heartbeat()->set_epoch(published_.server.epoch);
    message.mutable_heartbeat()->set_revision(revision);
    message.mutable_heartbeat()->set_root(published_.server.scene.root().asBytes());
    return message;
  }

  [[nodiscard]] MirrorView view() {
    link_.settle();
    return client_.view(kNow_ns);
  }

  static constexpr std::uint64_t kNow_ns = 1'000'000'000;
  PublishedSession published_;
  MemoryLink link_;
  std::optional<RelayedSession> session_;
  std::vector<ContentHash> asked_;
  std::unique_ptr<Transport> serverEnd_, clientEnd_;
  FrameDecoder decoder_;
  ClientSession client_{
      {.session = 77, .clientName = "test", .token = "", .telemetryRate_Hz = 60, .fetchAssets = true}};
};

TEST_F(Relayed, AClientHoldsThePublishedSceneAndMayNotEdit) {
  EXPECT_EQ(view().link, LinkState::kLive);
  EXPECT_EQ(view().scene->root(), published_.server.scene.root());
  EXPECT_EQ(view().device, "simulated");
  EXPECT_FALSE(view().mayEdit);
  EXPECT_EQ(asked_.size(), 2U);
}

TEST_F(Relayed, CommitsGoOnAndTheirRootsAreChecked) {
  ASSERT_TRUE(session_->commit(published_.commit("c").SerializeAsString()));
  EXPECT_EQ(view().scene->root(), published_.server.scene.root());
  auto forged = published_.commit("d");
  forged.mutable_commit()->mutable_put(0)->set_stiffness_n_per_m(1);
  ASSERT_TRUE(session_->commit(forged.SerializeAsString()));
  EXPECT_EQ(view().resyncs, 1U);
}

TEST_F(Relayed, ACommitThatIsHeldIsDroppedAndAGapEndsTheConnection) {
  const auto first = published_.commit("c");
  ASSERT_TRUE(session_->commit(first.SerializeAsString()));
  ASSERT_TRUE(session_->commit(first.SerializeAsString()));
  EXPECT_EQ(view().resyncs, 0U);
  (void)published_.commit("lost");
  EXPECT_FALSE(session_->commit(published_.commit("e").SerializeAsString()));
}

TEST_F(Relayed, AnotherEpochEndsTheConnection) {
  ++published_.server.epoch;
  EXPECT_FALSE(session_->commit(published_.commit("c").SerializeAsString()));
  EXPECT_FALSE(session_->sample(heartbeat(2).SerializeAsString()));
}

TEST_F(Relayed, AHeartbeatAheadOfItsCommitIsWaitedFor) {
  for (int i = 0; i < RelayedSession::kMaxHeartbeatsAhead; ++i) {
    ASSERT_TRUE(session_->sample(heartbeat(3).SerializeAsString()));
  }
  EXPECT_EQ(view().resyncs, 0U);
  ASSERT_TRUE(session_->commit(published_.commit("c").SerializeAsString()));
  ASSERT_TRUE(session_->sample(heartbeat(3).SerializeAsString()));
  EXPECT_EQ(view().resyncs, 0U);
  bool ended = false;
  for (int i = 0; i <= RelayedSession::kMaxHeartbeatsAhead; ++i)
    ended = !session_->sample(heartbeat(4).SerializeAsString());
  EXPECT_TRUE(ended);
}

TEST_F(Relayed, AHeartbeatWithAnotherRootIsNoticed) {
  auto message = heartbeat(published_.server.scene.revision());
  message.mutable_heartbeat()->mutable_root()->assign(32, 'x');
  ASSERT_TRUE(session_->sample(message.SerializeAsString()));
  EXPECT_EQ(view().resyncs, 1U);
}

TEST_F(Relayed, SamplesAreShownAndThoseOfAnotherEpochAreNot) {
  v1::LiveMessage message = live();
  message.mutable_telemetry()->set_tick(5);
  ASSERT_TRUE(session_->sample(message.SerializeAsString()));
  message.mutable_telemetry()->set_tick(9);
  message.set_epoch(7);
  ASSERT_TRUE(session_->sample(message.SerializeAsString()));
  EXPECT_EQ(view().sample->tick, 5U);
}

TEST_F(Relayed, WhatIsMalformedIsIgnored) {
  for (const std::string& bytes : {std::string(), std::string(100, '\xff'), live().SerializeAsString()}) {
    EXPECT_TRUE(session_->commit(bytes));
    EXPECT_TRUE(session_->sample(bytes));
  }
  EXPECT_EQ(session_->ignored(), 6U);
  EXPECT_EQ(view().link, LinkState::kLive);
}

TEST_F(Relayed, EditsUploadsDumpsAndTheLeadOfTheHandAreRefusedWithAReason) {
  std::string edit, upload, dump;
  client_.submit(removal(1),
                 {.replied = [&](const v1::EditReply& reply) { edit = reply.rejected().reason(); }, .live = {}});
  client_.upload(AssetKind::kMesh, std::string(200'000, 'x'),
                 {.progress = {}, .finished = [&](const v1::AssetUploadReply& reply) { upload = reply.reason(); }});
  client_.requestDump([&](const v1::DumpReply& reply) { dump = reply.reason(); });
  client_.leadHand(true, kNow_ns);
  const std::string hand = view().hand.refused;
  for (const std::string& reason : {edit, upload, dump, hand}) EXPECT_THAT(reason, testing::HasSubstr("only watched"));
}

}  // namespace
}  // namespace haptics::relayed_session_test
