#include "haptic_server/device/usb/choose_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics::test::choose_device_test {
namespace {

using ::testing::HasSubstr;

const std::vector<UsbPlace> kTwo{{1, 4, "1-2", "A1"}, {2, 7, "2-1.3", ""}};

TEST(ChooseDevice, TakesTheOnlyOne) {
  const auto chosen = chooseDevice(std::span(kTwo).first(1), "", "Falcon");
  ASSERT_TRUE(chosen);
  EXPECT_EQ(chosen->path, "1-2");
}

TEST(ChooseDevice, FindsBySerialAddressAndPort) {
  EXPECT_EQ(chooseDevice(kTwo, "A1", "Falcon")->address, 4);
  EXPECT_EQ(chooseDevice(kTwo, "002/007", "Falcon")->address, 7);
  EXPECT_EQ(chooseDevice(kTwo, "2-1.3", "Falcon")->address, 7);
}

TEST(ChooseDevice, OfSeveralNoneIsTakenUnasked) {
  const auto chosen = chooseDevice(kTwo, "", "Falcon");
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().fault, DeviceFault::kAmbiguous);
  const std::string text = chosen.error().error.text();
  EXPECT_THAT(text, HasSubstr("001/004 (port 1-2, serial A1)"));
  EXPECT_THAT(text, HasSubstr("002/007 (port 2-1.3)"));
  EXPECT_THAT(text, HasSubstr("--device NAME:A1"));
}

TEST(ChooseDevice, NoneOrAnUnknownNameIsRefused) {
  EXPECT_EQ(chooseDevice({}, "", "Falcon").error().fault, DeviceFault::kNotFound);
  EXPECT_THAT(chooseDevice({}, "", "Falcon").error().error.text(), HasSubstr("no Falcon is plugged in"));
  EXPECT_THAT(chooseDevice(kTwo, "B", "Falcon").error().error.text(), HasSubstr("\"B\""));
  EXPECT_THAT(chooseDevice(kTwo, "B", "Falcon").error().error.text(), HasSubstr("serial A1"));
}

}  // namespace
}  // namespace haptics::test::choose_device_test
