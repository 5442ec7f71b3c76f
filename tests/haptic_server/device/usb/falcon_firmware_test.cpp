#include "haptic_server/device/usb/falcon_firmware.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/device/usb/some_firmware.h"

namespace haptics::test::falcon_firmware_test {
namespace {

using ::testing::HasSubstr;

TEST(FalconFirmware, ABootStreamPasses) {
  const auto checked = checkFirmware(someFirmware());
  ASSERT_TRUE(checked) << checked.error().text();
  EXPECT_EQ(*checked, someFirmware());
}

TEST(FalconFirmware, CutOffAnywhereIsRefused) {
  const FalconFirmware whole = someFirmware();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const auto checked =
        checkFirmware(FalconFirmware(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)));
    ASSERT_FALSE(checked) << length;
    EXPECT_THAT(checked.error().reason, ::testing::AnyOf(HasSubstr("cut off"), HasSubstr("boot key"))) << length;
  }
}

TEST(FalconFirmware, SomethingElseIsRefusedByItsFirstWord) {
  const auto checked = checkFirmware({0x7F, 'E', 'L', 'F', 0, 0});
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().reason, HasSubstr("0x457F"));
}

TEST(FalconFirmware, BytesBehindItsEndAreRefused) {
  FalconFirmware longer = someFirmware();
  longer.push_back(0);
  const auto checked = checkFirmware(longer);
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().reason, HasSubstr("1 bytes after its end"));
}

TEST(FalconFirmware, NoProgramOrTooMuchIsRefused) {
  FalconFirmware empty(24, 0);
  empty[0] = 0xAA;
  empty[1] = 0x08;
  EXPECT_THAT(checkFirmware(empty).error().reason, HasSubstr("no program"));
  EXPECT_THAT(checkFirmware(FalconFirmware(kMaxFirmware_bytes + 1, 0)).error().reason, HasSubstr("at most"));
}

TEST(FalconFirmware, AFileThatIsNotThereIsRefusedByName) {
  EXPECT_THAT(readFirmware("/nonexistent/falcon.bin").error().text(), HasSubstr("/nonexistent/falcon.bin"));
  EXPECT_FALSE(readFirmware("/dev/zero"));
  EXPECT_FALSE(readFirmware("/"));
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder.path() / "fifo").c_str(), 0600), 0);
  EXPECT_FALSE(readFirmware(folder.path() / "fifo"));
}

}  // namespace
}  // namespace haptics::test::falcon_firmware_test
