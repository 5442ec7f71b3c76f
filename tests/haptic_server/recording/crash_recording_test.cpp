#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <new>
#include <thread>

#include "haptic_server/recording/last_seconds.h"
#include "haptic_server/recording/replay.h"
#include "haptic_server/recording/scene_journal.h"
#include "recorded_servo.h"

namespace haptics::crash_recording_test {
namespace {

using namespace test;

off_t sizeOf(int descriptor) {
  struct stat about {};
  fstat(descriptor, &about);
  return about.st_size;
}

/// As another process does it, which has nothing but two pieces of memory.
std::filesystem::path recordingOf(const RecordedServo& servo) {
  auto ring = FlightRing::attach(FileHandle(dup(servo.ring().descriptor()))).value();
  ring.releaseDeadWriter();
  return recordCrash({servo.folder() / "crash"}, ring, servo.journal()).value();
}

ReplayOutcome replayed(const std::filesystem::path& file) {
  auto outcome = replay(bytesOf(file));
  EXPECT_TRUE(outcome) << outcome.error().text();
  EXPECT_FALSE(outcome->refusal) << outcome->refusal->text();
  return *std::move(outcome);
}

TEST(CrashRecording, IsMadeOfWhatOutlivesTheProcessAndReplaysBitForBit) {
  RecordedServo servo(kScene + kBlock);
  servo.run(5000);
  servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
  servo.run(5000);
  servo.apply(R"(operations { remove { object { name: "ball" } } })");
  servo.run(5000);
  const auto file = recordingOf(servo);
  EXPECT_NE(file.string().find("-crash.haptics"), std::string::npos) << file;
  const auto outcome = replayed(file);
  EXPECT_EQ(outcome.differing, 0U);
  EXPECT_GE(outcome.ticks, 10'000U);
  EXPECT_LE(outcome.ticks, 12'000U);
  EXPECT_GT(outcome.contactTicks, 1000U);
  EXPECT_TRUE(outcome.sameStep);
}

TEST(CrashRecording, OfAServerWithoutASceneIsOneToo) {
  RecordedServo servo("");
  servo.run(1200);
  const auto outcome = replayed(recordingOf(servo));
  EXPECT_EQ(outcome.ticks, 1200U);
  EXPECT_EQ(outcome.differing, 0U);
}

TEST(CrashRecording, OfAJournalThatWasBeingWrittenHasWhatWasWhole) {
  RecordedServo servo;
  servo.run(2000);
  const off_t whole = sizeOf(servo.journal());
  servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
  for (off_t size = sizeOf(servo.journal()); size > whole; size -= 31) {
    ASSERT_EQ(ftruncate(servo.journal(), size), 0);
    const auto outcome = replayed(recordingOf(servo));
    EXPECT_EQ(outcome.differing, 0U);
    EXPECT_EQ(outcome.ticks, 2000U);
  }
  ASSERT_EQ(ftruncate(servo.journal(), 3), 0);
  auto ring = FlightRing::attach(FileHandle(dup(servo.ring().descriptor()))).value();
  const auto none = recordCrash({servo.folder() / "crash"}, ring, servo.journal());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().text(), "scene journal: does not begin with a head");
}

TEST(LastSeconds, AreKeptAlsoWhereTheirScenesTakeLongerToWriteThanTheRingKeepsTicks) {
  RecordedServo servo;
  servo.run(15'000);
  auto ring = FlightRing::attach(FileHandle(dup(servo.ring().descriptor()))).value();
  const auto scenes = SceneJournalReader::open(servo.journal()).value();
  const auto addSlowly = [&](RecordingWriter& writer, std::uint64_t) {
    scenes.forEach([&](std::string_view part) { writer.addPart(part); });
    servo.run(15'000);
  };
  const auto file = recordLastSeconds({servo.folder() / "slow"}, "slow", scenes.facts(), ring, addSlowly);
  ASSERT_TRUE(file) << file.error().text();
  const auto outcome = replayed(*file);
  EXPECT_EQ(outcome.differing, 0U);
  EXPECT_GE(outcome.ticks, 10'000U);
  EXPECT_LE(outcome.ticks, 11'000U);
}

TEST(CrashRecording, KeepsToItsQuota) {
  RecordedServo servo;
  servo.run(100);
  const auto folder = servo.folder() / "crash";
  const auto old = folder / "flight-0-crash.haptics";
  auto ring = FlightRing::attach(FileHandle(dup(servo.ring().descriptor()))).value();
  for (const std::size_t most_bytes : {std::size_t(1) << 30, std::size_t(1)}) {
    std::filesystem::create_directories(folder);
    std::ofstream(old) << "old";
    ASSERT_TRUE(recordCrash({folder, {.most_bytes = most_bytes}}, ring, servo.journal()));
    EXPECT_EQ(std::filesystem::exists(old), most_bytes > 1);
  }
}

TEST(LastSeconds, LeaveNoFileWithoutMemoryForThem) {
  RecordedServo servo;
  servo.run(100);
  auto ring = FlightRing::attach(FileHandle(dup(servo.ring().descriptor()))).value();
  RecordingFacts facts;
  facts.rate_Hz = RecordedServo::kRate_Hz;
  const auto none = recordLastSeconds({servo.folder() / "none"}, "none", facts, ring,
                                      [](RecordingWriter&, std::uint64_t) { throw std::bad_alloc(); });
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().reason, "std::bad_alloc");
  EXPECT_TRUE(std::filesystem::is_empty(servo.folder() / "none"));
}

TEST(FlightRecorder, GivesUpTheRecordingAndGoesOnWithoutMemory) {
  RecordedServo servo;
  servo.run(600);
  servo.onInfo = [] { throw std::bad_alloc(); };
  std::promise<bool> first, second;
  servo.recorder().start();
  servo.recorder().request("first", [&](const auto& file) { first.set_value(file.has_value()); });
  EXPECT_TRUE(first.get_future().get());
  std::this_thread::sleep_for(std::chrono::nanoseconds(FlightRecorder::kBetweenRequests_ns));
  servo.recorder().request("second", [&](const auto& file) { second.set_value(file.has_value()); });
  EXPECT_TRUE(second.get_future().get()) << "the thread goes on";
  const auto stopped = servo.recorder().stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().reason, "the recording is incomplete: std::bad_alloc");
}

TEST(FlightRecorder, RecordsNoFaultSoonAfterOneOfALargeScene) {
  RecordedServo servo(R"(operations { add { name: "ball" mesh { sphere { radius_m: 0.02 segments: 300 } } } })");
  servo.run(600);
  servo.recorder().start();
  const auto recordings = [&] {
    const auto folder = servo.folder() / "last";
    if (!std::filesystem::exists(folder)) return std::ptrdiff_t(0);
    return std::distance(std::filesystem::directory_iterator(folder), {});
  };
  const auto fault = [&] {
    servo.tick({{{}, DeviceState::kAbsent, {}}});
    servo.run(600);
  };
  fault();
  for (int i = 0; i < 500 && recordings() == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(recordings(), 1);
  fault();
  ASSERT_TRUE(servo.recorder().stop());
  EXPECT_EQ(recordings(), 1);
}

}  // namespace
}  // namespace haptics::crash_recording_test
