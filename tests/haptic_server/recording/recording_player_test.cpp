#include "haptic_server/recording/recording_player.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <future>
#include <new>
#include <thread>

#include "recorded_servo.h"

namespace haptics::recording_player_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A servo that runs what a player gives it, as fast as it goes.
class PlayingServo {
 public:
  /// @param unshown  The revision for which whoever shows scenes has no memory.
  explicit PlayingServo(const std::filesystem::path& file, std::uint64_t unshown = 0)
      : player_(RecordingPlayer::open(file).value()) {
    const auto prepared = player_->prepare(store_, [this, unshown](const RemadeScene& scene) {
      shown_.push_back(scene.version.revision());
      newestShown_ = scene.version.revision();
      if (newestShown_ == unshown) throw std::bad_alloc();
      return true;
    });
    EXPECT_TRUE(prepared) << prepared.error().text();
  }

  Result<std::string> play(double softer = 1) {
    StepConfig config = player_->facts().config;
    config.maxForce_N *= softer;
    auto state = std::make_unique<HapticState>(config);
    const ServoScene empty;
    const ServoScene* scene = &empty;
    const ServoScene* next = nullptr;
    if (const RecordedBeginning& begun = player_->beginning(); begun.state) {
      *state = *begun.state;
      if (begun.scene != nullptr) scene = begun.scene;
      next = begun.pending;
    }
    player_->start();
    for (ReplaySource::Tick tick;;) {
      const ReplaySource::Next what = player_->next(tick);
      if (what == ReplaySource::Next::kEnd) break;
      if (what == ReplaySource::Next::kNotYet) {
        std::this_thread::yield();
        continue;
      }
      if (tick.newest != nullptr) next = tick.newest;
      if (next != nullptr && adoptScene(*next, *state, tick.index)) scene = std::exchange(next, nullptr);
      player_->device().write(
          hapticStep(*scene, *state, config, {tick.index, 0, player_->device().read(tick.index)}).force.written);
      player_->releaseBefore(scene->number);
    }
    while (newestShown_ != scene->revision) std::this_thread::yield();
    player_->finish();
    return player_->verdict();
  }

  [[nodiscard]] const PlayedSoFar& played() const { return player_->played(); }
  [[nodiscard]] const std::vector<std::uint64_t>& shown() const { return shown_; }

 private:
  AssetStore store_;
  std::unique_ptr<RecordingPlayer> player_;
  std::vector<std::uint64_t> shown_;  // on the player's thread until finish()
  std::atomic<std::uint64_t> newestShown_{0};
};

std::filesystem::path fileOf(const RecordedServo& servo, const std::string& bytes) {
  const auto file = servo.folder() / "played";
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

void runWithEdits(RecordedServo& servo) {
  servo.run(6000);
  servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
  servo.run(500);
  servo.skip(3);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(500);
}

TEST(RecordingPlayer, GivesTheServoWhatItHadSoThatEveryForceIsTheRecordedOneAndShowsEachRevision) {
  RecordedServo servo(kScene + kBlock + kCushion);
  runWithEdits(servo);
  PlayingServo playing(fileOf(servo, servo.recording()));
  EXPECT_THAT(playing.shown(), ElementsAre(1)) << "what the first tick had is there from the start";
  const auto verdict = playing.play();
  ASSERT_TRUE(verdict) << verdict.error().text();
  EXPECT_THAT(*verdict, HasSubstr("7000 ticks; every force was the recorded one, bit for bit"));
  EXPECT_THAT(playing.shown(), ElementsAre(1, 2, 3));
}

TEST(RecordingPlayer, BeginsWithTheStateThatARecordingOfTheLastSecondsHolds) {
  RecordedServo servo(kScene + kBlock + kCushion);
  servo.run(9000);
  runWithEdits(servo);
  ASSERT_GT(servo.contactTicks(), 4000U);
  std::promise<std::filesystem::path> written;
  servo.recorder().start();
  servo.recorder().request("a test", [&](const auto& file) { written.set_value(file.value()); });
  PlayingServo playing(written.get_future().get());
  const auto verdict = playing.play();
  ASSERT_TRUE(verdict) << verdict.error().text();
  EXPECT_GE(playing.played().ticks, 10'000U);
  EXPECT_TRUE(playing.played().toItsEnd);
}

TEST(RecordingPlayer, SaysHowManyForcesDifferAndWhichFirst) {
  RecordedServo servo;
  servo.run(3000);
  PlayingServo playing(fileOf(servo, servo.recording()));
  const auto verdict = playing.play(0.05);
  ASSERT_FALSE(verdict);
  EXPECT_GT(playing.played().differing, 0U);
  EXPECT_THAT(verdict.error().reason, HasSubstr(std::to_string(playing.played().differing) + " of 3000 ticks"));
  EXPECT_THAT(verdict.error().reason, HasSubstr("tick " + std::to_string(playing.played().firstTick) + " first"));
}

/// As while it runs: in more than one part.
std::string recordingInParts(RecordedServo& servo) {
  servo.recorder().start();
  for (int part = 0; part < 3; ++part) {
    servo.run(1000);
    std::this_thread::sleep_for(std::chrono::nanoseconds(3 * FlightRecorder::kFlushEvery_ns));
  }
  EXPECT_TRUE(servo.recorder().stop());
  return bytesOf(servo.folder() / "all");
}

TEST(RecordingPlayer, SaysThatARecordingWasCutOffOrWhereItIsDamaged) {
  RecordedServo servo;
  std::string bytes = recordingInParts(servo);
  PlayingServo cut(fileOf(servo, bytes.substr(0, bytes.size() - 10)));
  EXPECT_THAT(cut.play().value(), HasSubstr("cut off"));
  EXPECT_GE(cut.played().ticks, 1000U);

  bytes[bytes.size() - 50] ^= 1;
  PlayingServo damaged(fileOf(servo, bytes));
  const auto verdict = damaged.play();
  ASSERT_FALSE(verdict);
  EXPECT_THAT(verdict.error().text(), HasSubstr("is damaged"));
  EXPECT_EQ(damaged.played().differing, 0U);
}

TEST(RecordingPlayer, SaysThatItCannotGoOnWithoutMemory) {
  RecordedServo servo;
  servo.run(100);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(100);
  const auto verdict = PlayingServo(fileOf(servo, servo.recording()), 2).play();
  ASSERT_FALSE(verdict);
  EXPECT_THAT(verdict.error().text(), HasSubstr("not played or shown any further: std::bad_alloc"));
}

TEST(RecordingPlayer, RefusesWhatIsNotThereOrHasNoTick) {
  const auto none = RecordingPlayer::open("/no/such/file");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().text(), HasSubstr("/no/such/file: No such file"));

  RecordedServo servo;
  auto player = RecordingPlayer::open(fileOf(servo, servo.recording()));
  ASSERT_TRUE(player) << player.error().text();
  AssetStore store;
  const auto prepared = (*player)->prepare(store, [](const RemadeScene&) { return true; });
  ASSERT_FALSE(prepared);
  EXPECT_THAT(prepared.error().text(), HasSubstr("ends before its first tick"));
}

}  // namespace
}  // namespace haptics::recording_player_test
