#include "graphics_client/session/recorded_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "graphics_client/mirror/mirror.h"
#include "tests/haptic_server/recording/recorded_servo.h"

namespace haptics::recorded_session_test {
namespace {

using namespace test;
using ::testing::HasSubstr;

std::filesystem::path fileOf(const TemporaryFolder& folder, const std::string& bytes) {
  const auto file = folder / "session.haptics";
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

TEST(RecordedSession, ShowsEveryMomentWithTheSceneThatWasFeltThen) {
  RecordedServo servo(kScene + kBlock);
  servo.run(2000);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(2000);
  const TemporaryFolder folder;
  double share = 0;
  const auto session = RecordedSession::read(fileOf(folder, servo.recording()), {}, [&](double done) { share = done; });
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_NEAR(session->duration_s(), 3.996, 1e-9);
  EXPECT_EQ(session->moments().list().size(), 1000U);
  EXPECT_GT(share, 0.9);
  EXPECT_EQ(session->verdict(), "every force is the same bit for bit");
  EXPECT_THAT(session->status(1), HasSubstr("replay of session.haptics, 1.00 s of 4.00 s; every force"));

  const auto before = session->view(session->moments().indexAt(1.9), 5), after = session->view(999, 6);
  ASSERT_TRUE(before->sample && after->sample);
  EXPECT_EQ(before->sample->tick, 1900U);
  EXPECT_TRUE(before->scene->find("ball"));
  EXPECT_FALSE(after->scene->find("ball"));
  EXPECT_EQ(before->link, LinkState::kLive);
  EXPECT_FALSE(before->mayEdit);
  EXPECT_TRUE(before->hashesEqual);
  EXPECT_TRUE(recomputedRoot(*before)) << "every mesh and field is there";
  EXPECT_EQ(recomputedRoot(*after).value(), after->scene->root());
  const ObjectId block = after->scene->find("block")->id;
  ASSERT_TRUE(after->bodies.contains(block));
  EXPECT_FALSE(after->bodies.at(block).pose == after->scene->find("block")->pose) << "the block must have been pushed";

  ASSERT_EQ(session->marks().size(), 1U);
  EXPECT_FALSE(session->marks()[0].isFault);
  EXPECT_NEAR(session->marks()[0].time_s, 2, 0.01);
}

TEST(RecordedSession, MarksAFaultWhereItBegins) {
  RecordedServo servo;
  servo.run(500);
  for (int i = 0; i < 100; ++i) servo.tick({Vec3(0), DeviceState::kStopped, {}});
  servo.run(500);
  const TemporaryFolder folder;
  const auto session = RecordedSession::read(fileOf(folder, servo.recording()), {});
  ASSERT_TRUE(session) << session.error().text();
  ASSERT_EQ(session->marks().size(), 1U);
  EXPECT_TRUE(session->marks()[0].isFault);
  EXPECT_NEAR(session->marks()[0].time_s, 0.5, 1e-9);
  EXPECT_EQ(session->marks()[0].text, "the device is not ready");
}

TEST(RecordedSession, ShowsWhatIsWholeOfADamagedFileAndSaysSo) {
  RecordedServo servo;
  servo.run(6000);
  const TemporaryFolder folder;
  const auto session = RecordedSession::read(fileOf(folder, servo.recording() + std::string(100, 'x')), {});
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_NEAR(session->duration_s(), 5.996, 1e-9);
  EXPECT_THAT(session->verdict(), HasSubstr("; it ends early: "));
}

TEST(RecordedSession, RefusesByNameWhatIsNoRecordingAndWhatIsNotThere) {
  const TemporaryFolder folder;
  const auto none = RecordedSession::read(fileOf(folder, "operations {}\n"), {});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().text(), HasSubstr("session.haptics"));
  EXPECT_THAT(none.error().text(), HasSubstr("no recording"));
  EXPECT_FALSE(RecordedSession::read(folder / "missing.haptics", {}));
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_FALSE(RecordedSession::read(folder / "fifo", {})) << "it does not wait for a writer";
}

TEST(RecordedSession, EndsWhenItIsCancelled) {
  RecordedServo servo;
  servo.run(3000);
  const TemporaryFolder folder;
  std::stop_source stop;
  int calls = 0;
  const auto session = RecordedSession::read(fileOf(folder, servo.recording()), stop.get_token(), [&](double) {
    if (++calls == 100) stop.request_stop();
  });
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error().text(), HasSubstr("cancelled"));
  EXPECT_EQ(calls, 100);
}

}  // namespace
}  // namespace haptics::recorded_session_test
