#include "common/text/printable.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/log/log.h"

namespace haptics::printable_test {
namespace {

TEST(Printable, PlainTextAndUtf8StayAsTheyAre) {
  for (const std::string text : {"", "plain ~ text \\x1b", "Größe µm 力 \U0001f60a"}) EXPECT_EQ(printable(text), text);
}

TEST(Printable, ControlCharactersAreEscaped) {
  EXPECT_EQ(printable("a\x1b[31m\r\n\t\x7f"), R"(a\x1b[31m\x0d\x0a\x09\x7f)");
  EXPECT_EQ(printable(std::string_view("\0b", 2)), R"(\x00b)");
  EXPECT_EQ(printable("\u0080\u009b31m\u009f\u00a0"), "\\x80\\x9b31m\\x9f\u00a0");
}

TEST(Printable, WhatTurnsTheDirectionOfWritingOrEndsALineIsEscaped) {
  EXPECT_EQ(printable("\u202a\u202e\u2066\u2069\u200f\u061c"), R"(\u202a\u202e\u2066\u2069\u200f\u061c)");
  EXPECT_EQ(printable("\u2028\u2029"), R"(\u2028\u2029)");
}

TEST(Printable, BytesThatAreNotUtf8AreEscaped) {
  EXPECT_EQ(printable("a\xff\xc3"), R"(a\xff\xc3)") << "torn";
  EXPECT_EQ(printable("\xc0\x9b\xe0\x82\x9b"), R"(\xc0\x9b\xe0\x82\x9b)") << "longer than needed";
  EXPECT_EQ(printable("\xed\xa0\x80"), R"(\xed\xa0\x80)") << "half a character";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), R"(\xf4\x90\x80\x80)") << "beyond the last";
  EXPECT_EQ(printable("\xc3(\x9b"), R"(\xc3(\x9b)");
}

TEST(AsUtf8, EscapesWhatIsNotUtf8Alone) {
  EXPECT_EQ(asUtf8("Gr\xf6\xdf"
                   "e\n\u202e\x1b Größe \xc3"),
            "Gr\\xf6\\xdfe\n\u202e\x1b Größe \\xc3");
}

TEST(Log, OneMessageIsOneLineWhateverItHolds) {
  logTo(stderr);
  testing::internal::CaptureStderr();
  logInfo("x\r\n06:00:00.000 error FORGED \x1b[31mGröße joined");
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_EQ(line.substr(line.find(' ')), " info x\\x0d\\x0a06:00:00.000 error FORGED \\x1b[31mGröße joined\n");
}

}  // namespace
}  // namespace haptics::printable_test
