#include <gmock/gmock.h>

#include "common/mesh/mesh_asset.h"
#include "tests/graphics_client/mirror/fake_server.h"

// What goes on while the client is in step: edits, telemetry, clock, heartbeats, uploads, status.
namespace haptics::session_traffic_test {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;

class SessionTraffic : public testing::Test {
 protected:
  void SetUp() override {
    rig_.server.addObject("a");
    rig_.join();
  }

  EditCallbacks callbacks() {
    return {.replied = [this](const v1::EditReply&) { ++replies_; }, .live = [this](const v1::EditLive&) { ++lives_; }};
  }

  /// Numbers of the edits heard on this connection.
  std::vector<std::uint64_t> heardEdits() const {
    std::vector<std::uint64_t> seqs;
    for (const auto& edit : rig_.server.heard(v1::Envelope::kEditRequest)) {
      seqs.push_back(edit.edit_request().client_seq());
    }
    return seqs;
  }

  void resume() {
    rig_.connect();
    rig_.server.welcome(true);
    rig_.settle();
  }

  using Seqs = std::vector<std::uint64_t>;

  SessionRig rig_;
  int replies_ = 0, lives_ = 0;
};

// ---- Edits ----

TEST_F(SessionTraffic, SaysFromWhichStateAnEditWasMade) {
  rig_.client.submit(removal(1), {});
  rig_.settle();
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kEditRequest)[0].edit_request().epoch(), rig_.server.epoch);
}

TEST_F(SessionTraffic, LearnsFromAHeartbeatThatAnEditIsLive) {
  rig_.client.submit(removal(1), callbacks());
  rig_.settle();
  rig_.server.accepted(1, 2);
  rig_.settle();
  rig_.cut();
  resume();
  EXPECT_EQ(heardEdits(), Seqs{});
  v1::Envelope envelope;
  envelope.mutable_heartbeat()->set_epoch(rig_.server.epoch);
  envelope.mutable_heartbeat()->set_revision(rig_.server.scene.revision());
  envelope.mutable_heartbeat()->set_root(rig_.server.scene.root().asBytes());
  envelope.mutable_heartbeat()->set_adopted_revision(2);
  envelope.mutable_heartbeat()->set_adoption_tick(900);
  rig_.server.send(envelope);
  rig_.settle();
  EXPECT_EQ(lives_, 1);
}

TEST_F(SessionTraffic, SendsAnEditThatCameTooEarlyAgainByItself) {
  rig_.client.submit(removal(1), callbacks());
  rig_.settle();
  v1::Envelope envelope;
  envelope.mutable_edit_reply()->set_client_seq(1);
  envelope.mutable_edit_reply()->mutable_rejected()->set_retry_after_ms(100);
  rig_.server.send(envelope);
  rig_.settle();
  EXPECT_EQ(heardEdits(), Seqs{1});
  rig_.advance(200 * kMillisecond_ns);
  EXPECT_EQ(heardEdits(), (Seqs{1, 1}));
  EXPECT_EQ(replies_, 0);
}

TEST_F(SessionTraffic, SendsAnEditAtOnceAndReportsBothAnswers) {
  rig_.client.submit(removal(1), callbacks());
  rig_.settle();
  EXPECT_EQ(heardEdits(), Seqs{1});
  rig_.server.accepted(1, 2);
  rig_.settle();
  EXPECT_EQ(replies_, 1);
  rig_.server.live(1, 2, 900);
  rig_.settle();
  EXPECT_EQ(lives_, 1);
}

TEST_F(SessionTraffic, ResendsAnEditUnchangedUntilItIsAnsweredAndReportsOnce) {
  rig_.client.submit(removal(1), callbacks());
  rig_.settle();
  const std::string first = rig_.server.heard(v1::Envelope::kEditRequest)[0].edit_request().SerializeAsString();
  for (int i = 0; i < 3; ++i) {
    rig_.cut();
    resume();
    const auto again = rig_.server.heard(v1::Envelope::kEditRequest);
    ASSERT_EQ(again.size(), 1U);
    EXPECT_EQ(again[0].edit_request().SerializeAsString(), first);
    EXPECT_EQ(rig_.server.heard(v1::Envelope::kHello)[0].hello().session(), 77U);
  }
  rig_.server.accepted(1, 2);
  rig_.server.live(1, 2, 900);
  rig_.settle();
  rig_.cut();
  resume();
  EXPECT_EQ(heardEdits(), Seqs{});
  EXPECT_EQ(replies_, 1);
  EXPECT_EQ(lives_, 1);
}

TEST_F(SessionTraffic, KeepsAnEditThatIsMadeWhileTheConnectionIsDown) {
  rig_.cut();
  rig_.client.submit(removal(1), callbacks());
  resume();
  EXPECT_EQ(heardEdits(), Seqs{1});
}

TEST_F(SessionTraffic, SendsUnansweredEditsToARestartedServerToo) {
  rig_.client.submit(removal(1), callbacks());
  rig_.client.submit(removal(1), callbacks());
  rig_.settle();
  rig_.server.accepted(1, 2);
  rig_.settle();
  rig_.cut();
  rig_.server.restart();
  rig_.join();
  EXPECT_EQ(heardEdits(), Seqs{2});  // the first was accepted by a server that has forgotten it
}

TEST_F(SessionTraffic, SendsTheNextEditsAsRepliesComeIn) {
  for (std::size_t i = 0; i < EditOutbox::kMaxInFlight + 1; ++i) rig_.client.submit(removal(1), {});
  rig_.settle();
  EXPECT_EQ(heardEdits().size(), EditOutbox::kMaxInFlight);
  rig_.server.accepted(1, 2);
  rig_.settle();
  EXPECT_EQ(heardEdits().size(), EditOutbox::kMaxInFlight + 1);
}

// ---- Telemetry and clock ----

TEST_F(SessionTraffic, ShowsTheNewestSample) {
  for (const std::uint64_t tick : {5, 7, 6}) rig_.server.telemetry(tick);
  rig_.settle();
  EXPECT_EQ(rig_.view().sample->tick, 7U);
  EXPECT_EQ(rig_.view().samplesReceived, 2U);
}

TEST_F(SessionTraffic, ShowsOfABatchWhatReachesTheNewestTickAlone) {
  const auto batch = [&](std::uint64_t tick, bool reachesNewest) {
    v1::Envelope envelope;
    v1::TelemetryBatch& message = *envelope.mutable_telemetry_batch();
    message.add_sample()->set_tick(tick);
    if (reachesNewest) {
      v1::Dent& dent = *message.mutable_sample(0)->add_dent();
      dent.set_object(1);
      for (int i = 0; i < 3; ++i) {
        dent.add_centre(0);
        dent.add_displacement(0.001F);
      }
    }
    message.set_reaches_newest(reachesNewest);
    rig_.server.send(envelope);
    rig_.settle();
  };
  batch(5, true);
  EXPECT_EQ(rig_.view().dents.size(), 1U);
  batch(6, false);
  EXPECT_EQ(rig_.view().sample->tick, 5U);
  EXPECT_EQ(rig_.view().dents.size(), 1U) << "the batch does not say that there are none";
}

TEST_F(SessionTraffic, CountsChangesOnlyWhereAViewWouldChange) {
  rig_.server.telemetry(5);
  rig_.settle();
  const std::uint64_t before = rig_.client.changes();
  rig_.server.telemetry(4);
  rig_.settle();
  EXPECT_EQ(rig_.client.changes(), before);
  rig_.server.telemetry(6);
  rig_.settle();
  EXPECT_GT(rig_.client.changes(), before);
}

TEST_F(SessionTraffic, ProbesTheClockOftenAtFirstAndThenSeldom) {
  std::size_t answered = 0;
  const auto answerProbes = [&](std::uint64_t duration_ns) {
    const std::size_t before = answered;
    for (std::uint64_t t = 0; t < duration_ns; t += 10 * kMillisecond_ns) {
      rig_.advance(10 * kMillisecond_ns);
      const auto probes = rig_.server.heard(v1::Envelope::kClockProbe);
      for (; answered < probes.size(); ++answered) {
        v1::Envelope reply;
        reply.mutable_clock_reply()->set_client_send_ns(probes[answered].clock_probe().client_send_ns());
        reply.mutable_clock_reply()->set_server_receive_ns(rig_.now_ns);
        reply.mutable_clock_reply()->set_server_send_ns(rig_.now_ns);
        rig_.server.send(reply);
      }
      rig_.settle();
    }
    return answered - before;
  };
  const std::size_t first = answerProbes(4 * kSecond_ns);
  EXPECT_GE(first, ClockOffset::kWindow);
  EXPECT_LE(first, 82U);  // 20 Hz for 4 s
  EXPECT_LE(answerProbes(4 * kSecond_ns), 5U);
}

TEST_F(SessionTraffic, TellsTheAgeOfASampleByTheServersClock) {
  constexpr std::uint64_t kServerAhead_ns = 12'345 * kSecond_ns;
  constexpr std::uint64_t kWay_ns = 4 * kMillisecond_ns;
  rig_.advance(ClientSession::kPoll_ns);
  const auto probe = rig_.server.heard(v1::Envelope::kClockProbe).at(0).clock_probe();
  v1::Envelope reply;
  reply.mutable_clock_reply()->set_client_send_ns(probe.client_send_ns());
  reply.mutable_clock_reply()->set_server_receive_ns(probe.client_send_ns() + kWay_ns + kServerAhead_ns);
  reply.mutable_clock_reply()->set_server_send_ns(probe.client_send_ns() + kWay_ns + kServerAhead_ns);
  rig_.server.send(reply);
  rig_.now_ns = probe.client_send_ns() + 2 * kWay_ns;
  rig_.settle();
  rig_.server.telemetry(1, rig_.now_ns + kServerAhead_ns - 30 * kMillisecond_ns);
  rig_.settle();
  const MirrorView view = rig_.view();
  EXPECT_NEAR(view.telemetryAge_s, 0.030, 1e-9);
  EXPECT_NEAR(view.clockUncertainty_s, 0.004, 1e-9);
  EXPECT_NEAR(view.telemetryAgeAt_s(rig_.now_ns + 5 * kMillisecond_ns), 0.035, 1e-9);
}

TEST_F(SessionTraffic, IgnoresAClockReplyFromTheFuture) {
  v1::Envelope reply;
  reply.mutable_clock_reply()->set_client_send_ns(rig_.now_ns + 1);
  rig_.server.send(reply);
  rig_.server.telemetry(1, 5);
  rig_.settle();
  EXPECT_EQ(rig_.view().telemetryAge_s, 0);
}

TEST_F(SessionTraffic, ChangesItsRateAndKeepsItOverAReconnect) {
  rig_.client.setTelemetryRate(200);
  rig_.settle();
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kSubscribe).back().subscribe().rate_hz(), 200);
  rig_.cut();
  resume();
  EXPECT_EQ(rig_.server.heard(v1::Envelope::kSubscribe).back().subscribe().rate_hz(), 200);
}

// ---- Life and death ----

TEST_F(SessionTraffic, SendsAHeartbeatWithItsRootEachSecond) {
  for (int i = 0; i < 10; ++i) {
    rig_.advance(kSecond_ns);
    rig_.server.heartbeat();
    rig_.settle();
  }
  const auto beats = rig_.server.heard(v1::Envelope::kHeartbeat);
  EXPECT_GE(beats.size(), 9U);
  EXPECT_LE(beats.size(), 11U);
  EXPECT_EQ(beats.back().heartbeat().root(), rig_.server.scene.root().asBytes());
  EXPECT_EQ(beats.back().heartbeat().epoch(), rig_.server.epoch);
}

TEST_F(SessionTraffic, TakesAServerForDeadAfterThreeSecondsWithoutAByte) {
  rig_.advance(ClientSession::kSilence_ns - ClientSession::kPoll_ns);
  EXPECT_EQ(rig_.connectionsEnded, 0);
  rig_.advance(2 * ClientSession::kPoll_ns);
  EXPECT_EQ(rig_.connectionsEnded, 1);
  EXPECT_THAT(rig_.view().linkText, HasSubstr("silent for 3 s"));
  resume();
  rig_.advance(kSecond_ns);
  EXPECT_EQ(rig_.connectionsEnded, 1);
}

TEST_F(SessionTraffic, TakesAnyByteForLife) {
  v1::Envelope envelope;
  envelope.set_protocol_version(kProtocolVersion);
  envelope.mutable_heartbeat()->set_revision(1);
  envelope.mutable_heartbeat()->set_root(rig_.server.scene.root().asBytes());
  std::string frame;
  (void)appendFrame(frame, envelope);
  for (std::size_t i = 0; i + 1 < frame.size(); ++i) {  // a frame that dribbles in for over a minute
    rig_.server.sendBytes(frame.substr(i, 1));
    rig_.advance(ClientSession::kSilence_ns - kSecond_ns);
  }
  EXPECT_EQ(rig_.connectionsEnded, 0);
}

TEST_F(SessionTraffic, WaitsThreeSecondsForAWelcome) {
  rig_.cut();
  rig_.connect();
  rig_.advance(ClientSession::kSilence_ns + ClientSession::kPoll_ns);
  EXPECT_EQ(rig_.connectionsEnded, 2);
}

// ---- Status ----

TEST_F(SessionTraffic, AsksForTheStatusUntilItIsAnswered) {
  int answers = 0;
  rig_.cut();
  for (int i = 0; i < 2; ++i) {
    rig_.client.requestStatus([&](const v1::Status& status) {
      EXPECT_EQ(status.ticks(), 42U);
      ++answers;
    });
  }
  for (int i = 0; i < 2; ++i) {
    resume();
    EXPECT_EQ(rig_.server.heard(v1::Envelope::kStatusRequest).size(), 1U);
    if (i == 0) rig_.cut();
  }
  v1::Envelope status;
  status.mutable_status()->set_ticks(42);
  rig_.server.send(status);
  rig_.server.send(status);
  rig_.settle();
  EXPECT_EQ(answers, 2);
}

// ---- Uploads ----

TEST_F(SessionTraffic, UploadsAMeshInChunksThatLeaveRoomForOthers) {
  const std::string bytes = encodeMesh(grid(200));
  bool finished = false;
  rig_.client.upload(AssetKind::kMesh, bytes,
                     {.progress = {}, .finished = [&](const auto& reply) { finished = reply.accepted(); }});
  EXPECT_LT(rig_.clientEnd->backlog(), 2 * ClientSession::kUploadBacklog_bytes);
  rig_.settle();
  std::string arrived;
  for (const auto& upload : rig_.server.heard(v1::Envelope::kAssetUpload))
    arrived += upload.asset_upload().chunk().data();
  EXPECT_EQ(arrived, bytes);
  v1::Envelope reply;
  reply.mutable_asset_upload_reply()->set_hash(hashOf(grid(200)).asBytes());
  reply.mutable_asset_upload_reply()->set_accepted(true);
  rig_.server.send(reply);
  rig_.settle();
  EXPECT_TRUE(finished);
}

TEST_F(SessionTraffic, UploadsFromTheStartAgainAfterAReconnect) {
  const std::string bytes = encodeMesh(grid(200));
  rig_.client.upload(AssetKind::kMesh, bytes, {});
  rig_.link->pump(100'000);
  rig_.cut();
  resume();
  const auto uploads = rig_.server.heard(v1::Envelope::kAssetUpload);
  ASSERT_FALSE(uploads.empty());
  EXPECT_EQ(uploads[0].asset_upload().chunk().offset(), 0U);
}

TEST_F(SessionTraffic, UploadsAgainBeforeTheEditThatNamesIt) {
  v1::Envelope reply;
  reply.mutable_asset_upload_reply()->set_hash(hashOf(grid(20)).asBytes());
  reply.mutable_asset_upload_reply()->set_accepted(true);
  rig_.client.upload(AssetKind::kMesh, encodeMesh(grid(20)), {});
  rig_.settle();
  rig_.server.send(reply);
  rig_.settle();
  rig_.client.submit(removal(1), callbacks());
  rig_.cut();
  resume();
  ASSERT_FALSE(rig_.server.heard(v1::Envelope::kAssetUpload).empty());
  EXPECT_EQ(heardEdits(), Seqs{});
  rig_.server.send(reply);
  rig_.settle();
  EXPECT_EQ(heardEdits(), Seqs{1});
}

TEST_F(SessionTraffic, TellsTheServerThatAnUploadIsCancelledAndGoesOnWithTheNext) {
  const ContentHash first = hashOf(grid(200));
  bool cancelled = false;
  rig_.client.upload(AssetKind::kMesh, encodeMesh(grid(200)),
                     {.progress = {}, .finished = [&](const auto& r) { cancelled = !r.accepted(); }});
  rig_.client.upload(AssetKind::kMesh, encodeMesh(grid(20)), {});
  rig_.client.cancelUpload(first);
  EXPECT_TRUE(cancelled);
  rig_.settle();
  const auto uploads = rig_.server.heard(v1::Envelope::kAssetUpload);
  ASSERT_GT(uploads.size(), 2U);
  EXPECT_EQ(uploads.back().asset_upload().chunk().hash(), hashOf(grid(20)).asBytes());
  EXPECT_EQ(std::ranges::count_if(uploads, [&](const auto& u) { return u.asset_upload().cancel() == first.asBytes(); }),
            1);
}

}  // namespace
}  // namespace haptics::session_traffic_test
