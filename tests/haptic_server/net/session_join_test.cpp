#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "haptic_server/engine/step/servo_scene.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics::session_join_test {
namespace {

using namespace test;
using ::testing::HasSubstr;
using Kind = v1::Envelope;

class SessionJoin : public ::testing::Test, public SessionWorld {
 protected:
  using SessionWorld::SessionWorld;
  /// The scene as a correct client makes it from the messages so far, checking each root on the way.
  SceneVersion mirror(SceneVersion scene = {}) const {
    std::vector<ObjectRecord> snapshot;
    for (const v1::Envelope& envelope : client.got) {
      if (envelope.has_snapshot_begin()) snapshot.clear();
      for (const auto& object : envelope.snapshot_objects().object()) snapshot.push_back(fromWire(object).value());
      if (envelope.has_snapshot_end()) {
        scene = SceneVersion::fromSnapshot(envelope.snapshot_end().revision(), snapshot).value();
        EXPECT_EQ(scene.root().asBytes(), envelope.snapshot_end().root());
      }
      if (!envelope.has_commit()) continue;
      EXPECT_EQ(scene.root().asBytes(), envelope.commit().prev_root());
      scene = scene.apply(fromWire(envelope.commit()).value()).value();
      EXPECT_EQ(scene.root().asBytes(), envelope.commit().root());
    }
    return scene;
  }
  Transaction full() {
    Transaction all;
    for (std::size_t i = 0; i < kMaxServoObjects; ++i) {
      all.operations.push_back(add(std::string(60, 'x').append(std::to_string(i))));
    }
    return all;
  }
};

TEST_F(SessionJoin, WelcomesWithASnapshotOfOneRevision) {
  edit(test::edit(add("a"), add("b")));
  client.hello();
  link.settle();
  ASSERT_EQ(client.got.size(), 4U);
  const v1::Welcome& welcome = client.got[0].welcome();
  EXPECT_EQ(welcome.epoch(), 5U);
  EXPECT_EQ(welcome.revision(), 1U);
  EXPECT_EQ(welcome.root(), history()->version.root().asBytes());
  EXPECT_FALSE(welcome.resumed());
  EXPECT_EQ(welcome.device(), "simulated");
  EXPECT_TRUE(welcome.may_edit());
  EXPECT_EQ(client.got[1].snapshot_begin().object_count(), 2U);
  EXPECT_EQ(mirror().root(), history()->version.root());
  for (std::size_t i = 0; i < client.got.size(); ++i) EXPECT_EQ(client.got[i].message_id(), i + 1);
  EXPECT_EQ(claimed, kClientSession);
}

TEST_F(SessionJoin, CutsALargeSnapshotIntoMessagesAndSendsWhatCameAfterItInOrder) {
  edit(full());
  client.hello();
  link.pump();  // Hello arrives
  edit(test::edit(remove(std::string(60, 'x') + "0")));
  for (int i = 0; i < 20; ++i) {
    link.pump(10'000);
    edit(test::edit(moveTo(std::string(60, 'x') + "1", {double(i), 0, 0})));
  }
  link.settle();
  const auto parts = client.all(Kind::kSnapshotObjects);
  EXPECT_GT(parts.size(), 1U);
  for (const v1::Envelope& part : parts) EXPECT_LE(part.snapshot_objects().ByteSizeLong(), kMaxChunkBytes);
  EXPECT_EQ(client.all(Kind::kSnapshotBegin).at(0).snapshot_begin().revision(), 1U);
  EXPECT_EQ(client.count(Kind::kCommit), 21U);
  EXPECT_EQ(mirror().root(), history()->version.root());
}

TEST_F(SessionJoin, ResumesWithTheCommitsThatTheClientMissed) {
  edit(test::edit(add("a")));
  const SceneVersion held = history()->version;
  edit(test::edit(add("b")));
  edit(test::edit(remove("a")));
  client.hello(5, held.revision(), held.root());
  link.settle();
  EXPECT_TRUE(client.got.at(0).welcome().resumed());
  EXPECT_EQ(client.got.at(0).welcome().revision(), 3U);
  EXPECT_EQ(client.count(Kind::kSnapshotBegin), 0U);
  EXPECT_EQ(client.count(Kind::kCommit), 2U);
  EXPECT_EQ(mirror(held).root(), history()->version.root());
}

TEST_F(SessionJoin, SendsASnapshotToAClientOfAnotherEpochOrHistory) {
  for (const bool otherEpoch : {true, false}) {
    SessionWorld world;
    world.edit(test::edit(add("a")));
    world.client.hello(otherEpoch ? 6 : 5, 1, otherEpoch ? world.history()->version.root() : SceneVersion().root());
    world.link.settle();
    EXPECT_FALSE(world.client.got.at(0).welcome().resumed());
    EXPECT_EQ(world.client.count(Kind::kSnapshotEnd), 1U);
  }
}

TEST_F(SessionJoin, ClosesAClientThatConnectsAndSaysNothing) {
  pass(3 * kSecond_ns - 2 * kMillisecond_ns);
  EXPECT_FALSE(client.closed);
  pass(2 * kMillisecond_ns);
  EXPECT_EQ(client.refusal().field(), "hello");
  EXPECT_TRUE(client.closed);
  EXPECT_TRUE(over);
  EXPECT_EQ(refusals.size(), 1U);
}

TEST_F(SessionJoin, AHelloThatDribblesInIsNotWaitedForLonger) {
  for (int i = 0; i < 40; ++i) {
    client.sendBytes(i == 0 ? std::string("\x40\0\0\0", 4) : "x");
    pass(100 * kMillisecond_ns);
  }
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionJoin, NamesTheVersionThatItSpeaks) {
  v1::Envelope hello;
  hello.set_protocol_version(2);
  hello.mutable_hello()->set_session(1);
  client.send(hello);
  link.settle();
  EXPECT_EQ(client.refusal().field(), "protocol_version");
  EXPECT_EQ(client.refusal().supported_version(), kProtocolVersion);
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionJoin, RefusesWhatIsNoHello) {
  const auto refusedField = [](const std::function<void(RawClient&)>& say) {
    SessionWorld world;
    say(world.client);
    world.link.settle();
    EXPECT_TRUE(world.client.closed);
    return world.client.refusal().field();
  };
  EXPECT_EQ(refusedField([](RawClient& c) { c.heartbeat(); }), "hello");
  EXPECT_EQ(refusedField([](RawClient& c) { c.hello(0, 0, {}, 0); }), "hello.session");
  EXPECT_EQ(refusedField([](RawClient& c) {
              v1::Envelope envelope;
              envelope.mutable_hello()->set_session(1);
              envelope.mutable_hello()->set_client_name(std::string(65, 'n'));
              c.send(envelope);
            }),
            "hello.client_name");
  EXPECT_EQ(refusedField([](RawClient& c) {
              c.hello();
              c.hello();
            }),
            "body");
  EXPECT_EQ(refusedField([](RawClient& c) {
              c.hello();
              v1::Envelope envelope;
              envelope.mutable_welcome();
              c.send(envelope);
            }),
            "body");
}

TEST_F(SessionJoin, RefusesAFrameThatClaimsFourGigabytes) {
  client.sendBytes("\xff\xff\xff\xff");
  link.settle();
  EXPECT_FALSE(client.refusal().reason().empty());
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionJoin, RefusesMoreThanAHelloBeforeAnyoneIsKnown) {
  client.sendBytes(std::string("\x01\x04\0\0", 4));  // 1,025 bytes
  link.settle();
  EXPECT_EQ(client.refusal().field(), "frame.length");
  EXPECT_THAT(client.refusal().reason(), HasSubstr("1024"));
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionJoin, RefusesANameThatWouldForgeALogLine) {
  v1::Envelope envelope;
  envelope.mutable_hello()->set_session(1);
  envelope.mutable_hello()->set_client_name("a\nerror: forged");
  client.send(envelope);
  link.settle();
  EXPECT_EQ(client.refusal().field(), "hello.client_name");
}

/// Frames so small that the start scene's commit fits none.
class SessionOfSmallFrames : public SessionJoin {
 protected:
  static constexpr FrameLimits kFrames{.frame_bytes = 4096, .chunk_bytes = 2048};
  static constexpr std::size_t kObjects = 40;
  SessionOfSmallFrames() : SessionJoin({.frames = kFrames}) {
    Transaction scene;
    for (std::size_t i = 0; i < kObjects; ++i) scene.operations.push_back(add(numbered("o", i)));
    start = edit(scene);
  }
  void expectSmallFrames() const {
    for (const v1::Envelope& envelope : client.got) EXPECT_LE(envelope.ByteSizeLong(), kFrames.frame_bytes);
  }
  Accepted start;
};

TEST_F(SessionOfSmallFrames, WhoLacksACommitThatFitsNoFrameGetsASnapshot) {
  client.hello(5, 0, SceneVersion().root());
  link.settle();
  EXPECT_FALSE(client.all(Kind::kWelcome).at(0).welcome().resumed());
  EXPECT_EQ(mirror().root(), history()->version.root());
  expectSmallFrames();
}

TEST_F(SessionOfSmallFrames, ACommitThatFitsNoFrameEndsOneSessionWithItsReason) {
  join();
  Transaction all;
  for (std::size_t i = 0; i < kObjects; ++i) all.operations.push_back(moveTo(numbered("o", i), {1, 0, 0}));
  edit(all);
  link.settle();
  EXPECT_EQ(client.refusal().field(), "frame.length");
  EXPECT_THAT(client.refusal().reason(), HasSubstr("snapshot"));
  EXPECT_TRUE(client.closed);
}

TEST_F(SessionOfSmallFrames, AnAnswerThatFitsNoFrameNamesItsRevision) {
  join();
  session.editDecided(1, EditOutcome(start));
  link.settle();
  const v1::Accepted accepted = client.all(Kind::kEditReply).at(0).edit_reply().accepted();
  EXPECT_EQ(accepted.revision(), 1U);
  EXPECT_EQ(accepted.root(), start->commit.root.asBytes());
  EXPECT_EQ(accepted.object_size(), 0);
}

TEST_F(SessionOfSmallFrames, AConflictShowsTheObjectsThatFit) {
  join();
  EditConflict conflict{{}, std::string(10'000, 'r')};
  for (const auto& object : history()->version.objects()) conflict.current.push_back(object);
  session.editDecided(1, EditOutcome(conflict));
  session.editDecided(2, EditOutcome(Error{std::string(10'000, 'f'), std::string(10'000, 'r')}));
  link.settle();
  const v1::Conflict shown = client.all(Kind::kEditReply).at(0).edit_reply().conflict();
  EXPECT_GT(shown.current_size(), 0);
  EXPECT_LT(shown.current_size(), static_cast<int>(kObjects));
  EXPECT_THAT(shown.reason(), HasSubstr("of 40 objects, " + std::to_string(shown.current_size()) + " are shown"));
  expectSmallFrames();
}

TEST(SessionGarbage, RandomBytesAreRefusedOrIgnoredAndNeverHarm) {
  std::mt19937 random(3);
  int refused = 0;
  for (int round = 0; round < 300; ++round) {
    SessionWorld world;
    if (round % 2 == 0) world.join();
    std::string bytes(random() % 200, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    if (round % 3 == 0 && bytes.size() > 4) bytes.replace(0, 4, {static_cast<char>(bytes.size() - 4), 0, 0, 0});
    world.client.sendBytes(bytes);
    world.link.settle();
    world.pass(4 * kSecond_ns, kSecond_ns);
    EXPECT_TRUE(world.client.closed);
    refused += static_cast<int>(world.refusals.size());
  }
  EXPECT_EQ(refused, 300);
}

TEST_F(SessionJoin, ABrokenMessageAmongGoodOnesIsRefused) {
  std::mt19937 random(4);
  v1::Envelope good;
  good.set_protocol_version(kProtocolVersion);
  good.mutable_edit_request()->set_client_seq(1);
  good.mutable_edit_request()->mutable_transaction()->add_operations()->mutable_add()->set_name("a");
  std::string frame;
  ASSERT_TRUE(appendFrame(frame, good));
  for (int round = 0; round < 300; ++round) {
    SessionWorld world;
    world.join();
    std::string bytes = frame;
    bytes[random() % bytes.size()] = static_cast<char>(random());
    world.client.sendBytes(bytes);
    world.link.settle();
    EXPECT_LE(world.client.got.size(), 1U);
  }
}

TEST_F(SessionJoin, AClientIsDeadAfterThreeSecondsWithoutAByte) {
  join();
  for (int i = 0; i < 5; ++i) {
    pass(2 * kSecond_ns);
    client.sendBytes(i < 4 ? std::string(1, "\x02\0\0\0"[i]) : "");
    link.settle();
  }
  EXPECT_FALSE(client.closed) << "any byte counts";
  pass(kSecond_ns);
  EXPECT_TRUE(client.closed);
  EXPECT_EQ(client.refusal().field(), "heartbeat");
}

TEST_F(SessionJoin, BeatsOnceASecondWithTheRevisionAndRootOfTheStreamSoFar) {
  join();
  edit(test::edit(add("a")));
  for (int i = 0; i < 5; ++i) {
    pass(kSecond_ns);
    client.heartbeat();
  }
  const auto beats = client.all(Kind::kHeartbeat);
  ASSERT_EQ(beats.size(), 5U);
  EXPECT_EQ(beats[0].heartbeat().epoch(), 5U);
  EXPECT_EQ(beats[0].heartbeat().revision(), 1U);
  EXPECT_EQ(beats[0].heartbeat().root(), history()->version.root().asBytes());
}

TEST_F(SessionJoin, AHeartbeatBehindUnsentCommitsNamesTheRevisionBeforeThem) {
  join();
  // The client stops reading: commits wait behind what is queued.
  Transaction large = full();
  edit(large);
  for (int i = 0; i < 40; ++i) {
    Transaction all;
    for (std::size_t o = 0; o < kMaxServoObjects; ++o) {
      all.operations.push_back(moveTo(std::string(60, 'x').append(std::to_string(o)), {double(i), 0, 0}));
    }
    edit(all);
  }
  time_ns += kSecond_ns;
  session.poll();
  link.settle();
  SceneVersion scene;
  std::size_t beats = 0;
  for (const v1::Envelope& envelope : client.got) {
    if (envelope.has_commit()) scene = scene.apply(fromWire(envelope.commit()).value()).value();
    if (!envelope.has_heartbeat()) continue;
    ++beats;
    EXPECT_EQ(envelope.heartbeat().revision(), scene.revision());
    EXPECT_EQ(envelope.heartbeat().root(), scene.root().asBytes());
    EXPECT_LT(scene.revision(), 41U);
  }
  EXPECT_EQ(beats, 1U);
  EXPECT_EQ(scene.revision(), 41U);
}

}  // namespace
}  // namespace haptics::session_join_test
