#include "haptic_server/recording/recording_quota.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/common/temporary_folder.h"

namespace haptics::recording_quota_test {
namespace {

using test::TemporaryFolder;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

class RecordingQuotaTest : public ::testing::Test {
 protected:
  void put(const std::string& name) { std::ofstream(folder / name) << std::string(1000, 'x'); }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.path())) names.push_back(entry.path().filename());
    return names;
  }
  TemporaryFolder folder;
};

TEST_F(RecordingQuotaTest, TheOldestGoFirst) {
  for (const char* name : {"flight-1-on_request.haptics", "flight-2-on_request.haptics", "flight-3-on_request.haptics"})
    put(name);
  put("flight-0.txt");
  put("mine.haptics");
  rotateRecordings(folder.path(), {.most_bytes = 2500});
  EXPECT_THAT(names(), UnorderedElementsAre("flight-2-on_request.haptics", "flight-3-on_request.haptics",
                                            "flight-0.txt", "mine.haptics"));
}

TEST_F(RecordingQuotaTest, TheNewestOfAFaultStays) {
  for (const char* name : {"flight-1-device_lost.haptics", "flight-2-device_lost.haptics",
                           "flight-3-on_request.haptics", "flight-4-on_request.haptics"})
    put(name);
  rotateRecordings(folder.path(), {.maxFiles = 2});
  EXPECT_THAT(names(), UnorderedElementsAre("flight-2-device_lost.haptics", "flight-4-on_request.haptics"));
}

TEST_F(RecordingQuotaTest, TheLastStaysWhateverItTakes) {
  put("flight-1-on_request.haptics");
  rotateRecordings(folder.path(), {.most_bytes = 10});
  EXPECT_THAT(names(), UnorderedElementsAre("flight-1-on_request.haptics"));
}

TEST_F(RecordingQuotaTest, SomeOfTheDiskIsLeft) {
  put("flight-1-on_request.haptics");
  EXPECT_TRUE(makeRoomForRecording(folder.path(), {.leave_bytes = 1}));
  EXPECT_FALSE(makeRoomForRecording("/proc", {})) << "that has no space at all";
}

}  // namespace
}  // namespace haptics::recording_quota_test
