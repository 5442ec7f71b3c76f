#include "haptic_server/device/usb/falcon_frame.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace haptics::test::falcon_frame_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const std::string& text) { return {text.begin(), text.end()}; }

/// A reply as the device sends it: flags of buttons and homed axes.
Bytes replyOf(std::array<std::int16_t, 3> counts, unsigned buttons, unsigned homed) {
  const FalconFrame frame = encode({.motors = counts});
  Bytes bytes(frame.begin(), frame.end());
  bytes[13] = static_cast<std::uint8_t>('A' + (homed << 4 | buttons));
  return bytes;
}

std::vector<DeviceReply> readAll(FalconReplyReader& reader, const Bytes& bytes) {
  std::vector<DeviceReply> replies;
  for (const std::uint8_t byte : bytes) {
    if (const auto reply = reader.take(byte)) replies.push_back(*reply);
  }
  return replies;
}

TEST(FalconFrame, WritesNibblesFromTheLowestUp) {
  const FalconFrame frame = encode({.motors = {0x1234, -1, 0}, .homing = true, .red = true});
  EXPECT_EQ(std::string(frame.begin(), frame.end()), "<EDCBPPPPAAAAJA>");
}

TEST(FalconFrame, ReadsBackEveryNumberButtonAndHomedAxis) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> number(-32768, 32767);
  FalconReplyReader reader;
  for (unsigned flags = 0; flags < 128; ++flags) {
    const std::array counts{static_cast<std::int16_t>(number(random)), static_cast<std::int16_t>(number(random)),
                            static_cast<std::int16_t>(number(random))};
    const auto replies = readAll(reader, replyOf(counts, flags & 15, flags >> 4));
    ASSERT_EQ(replies.size(), 1U);
    EXPECT_EQ(replies[0].counts, counts);
    EXPECT_EQ(replies[0].buttons, flags & 15);
    EXPECT_EQ(replies[0].homedAxes, flags >> 4);
  }
  EXPECT_EQ(reader.skippedBytes(), 0U);
}

TEST(FalconFrame, FindsTheNextReplyBehindAnyDamagedByte) {
  const Bytes whole = replyOf({1, 2, 3}, 0, 7);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const std::uint8_t wrong : bytesOf(std::string("\0<>@Q\xFF", 6))) {
      Bytes stream = whole;
      if (stream[at] == wrong || (at == 13 && wrong == 'Q')) continue;
      stream[at] = wrong;
      stream.insert(stream.end(), whole.begin(), whole.end());
      FalconReplyReader reader;
      const auto replies = readAll(reader, stream);
      ASSERT_EQ(replies.size(), 1U) << "byte " << at << " became " << int{wrong};
      EXPECT_EQ(replies[0].counts[2], 3);
      EXPECT_GT(reader.skippedBytes(), 0U);
    }
  }
}

TEST(FalconFrame, FindsTheNextReplyBehindOneThatIsShortByAnyNumberOfBytes) {
  const Bytes whole = replyOf({-5, 6, -7}, 8, 7);
  for (std::size_t cut = 1; cut < whole.size(); ++cut) {
    for (const bool fromItsHead : {false, true}) {
      Bytes stream(fromItsHead ? whole.begin() + static_cast<std::ptrdiff_t>(cut) : whole.begin(),
                   fromItsHead ? whole.end() : whole.end() - static_cast<std::ptrdiff_t>(cut));
      stream.insert(stream.end(), whole.begin(), whole.end());
      FalconReplyReader reader;
      const auto replies = readAll(reader, stream);
      ASSERT_EQ(replies.size(), 1U) << cut;
      EXPECT_EQ(replies[0].counts[0], -5);
      EXPECT_EQ(reader.skippedBytes(), whole.size() - cut);
    }
  }
}

TEST(FalconFrame, NoiseIsNeverAReplyWithDigitsThatAreNone) {
  std::mt19937 random(9);
  std::uniform_int_distribution<int> byte(0, 255);
  FalconReplyReader reader;
  for (int i = 0; i < 200'000; ++i) EXPECT_FALSE(reader.take(static_cast<std::uint8_t>(byte(random))));
}

}  // namespace
}  // namespace haptics::test::falcon_frame_test
