#include "graphics_client/video/webm_writer.h"

#include <gmock/gmock.h>
#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "tests/common/temporary_folder.h"

namespace haptics {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth_px = 150, kHeight_px = 62;  // rows are filled up
constexpr std::size_t kRow_bytes = 452;
constexpr int kBits = 7, kBit_px = 20;

/// A frame that carries its number: a column for each bit, white where it is set, over a ground that grows brighter
/// downwards.
std::vector<std::uint8_t> frameOf(unsigned number) {
  std::vector<std::uint8_t> rgb(kRow_bytes * kHeight_px);
  for (int y = 0; y < kHeight_px; ++y) {
    for (int x = 0; x < kWidth_px; ++x) {
      const bool isSet = x / kBit_px < kBits && (number >> (x / kBit_px) & 1U) != 0;
      const auto ground = static_cast<std::uint8_t>(y < kHeight_px / 2 ? 20 : 80);
      for (int c = 0; c < 3; ++c) {
        rgb[kRow_bytes * static_cast<std::size_t>(y) + static_cast<std::size_t>(3 * x + c)] = isSet ? 230 : ground;
      }
    }
  }
  return rgb;
}

struct Decoded {
  unsigned number;
  double time_s;
  bool isUpright;
};

/// By another program's parts: what a player would show.
std::vector<Decoded> decode(const std::filesystem::path& file) {
  gst_init(nullptr, nullptr);
  GstElement* all = gst_parse_launch(
      "filesrc name=in ! matroskademux ! vp8dec ! videoconvert ! video/x-raw,format=RGB ! appsink name=out sync=false",
      nullptr);
  GstElement* in = gst_bin_get_by_name(GST_BIN(all), "in");
  GstElement* out = gst_bin_get_by_name(GST_BIN(all), "out");
  g_object_set(in, "location", file.c_str(), nullptr);
  gst_element_set_state(all, GST_STATE_PLAYING);
  std::vector<Decoded> frames;
  while (GstSample* sample = gst_app_sink_pull_sample(GST_APP_SINK(out))) {
    GstBuffer* buffer = gst_sample_get_buffer(sample);
    GstMapInfo map;
    gst_buffer_map(buffer, &map, GST_MAP_READ);
    EXPECT_EQ(map.size, kRow_bytes * kHeight_px);
    const auto at = [&](int x, int y) {
      return map.data[kRow_bytes * static_cast<std::size_t>(y) + static_cast<std::size_t>(3 * x)];
    };
    unsigned number = 0;
    for (int bit = 0; bit < kBits; ++bit) number |= (at(kBit_px * bit + kBit_px / 2, 10) > 125 ? 1U : 0U) << bit;
    constexpr int kGround_x = 145;
    frames.push_back(
        {number, 1e-9 * static_cast<double>(GST_BUFFER_PTS(buffer)), at(kGround_x, 5) < at(kGround_x, 55)});
    gst_buffer_unmap(buffer, &map);
    gst_sample_unref(sample);
  }
  gst_element_set_state(all, GST_STATE_NULL);
  for (GstElement* each : {in, out, all}) gst_object_unref(each);
  return frames;
}

TEST(WebmWriter, EachFrameComesBackInItsPlaceAtItsTime) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "counted video.webm";
  constexpr unsigned kFrames = 90;
  constexpr double kRate_Hz = 25;
  {
    auto writer = WebmWriter::create(file, kWidth_px, kHeight_px, kRate_Hz);
    ASSERT_TRUE(writer) << writer.error().text();
    for (unsigned i = 0; i < kFrames; ++i) ASSERT_TRUE(writer->add(frameOf(i), i / kRate_Hz));
    ASSERT_TRUE(writer->finish());
  }
  const std::vector<Decoded> frames = decode(file);
  ASSERT_EQ(frames.size(), kFrames);
  for (unsigned i = 0; i < kFrames; ++i) {
    EXPECT_EQ(frames[i].number, i);
    EXPECT_NEAR(frames[i].time_s, i / kRate_Hz, 0.002);  // WebM counts milliseconds
    EXPECT_TRUE(frames[i].isUpright);
  }
}

TEST(WebmWriter, FramesMayComeAtAnyTimes) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "uneven.webm";
  const std::vector<double> times_s{0, 0.05, 0.4, 1.7, 1.75};
  {
    auto writer = WebmWriter::create(file, kWidth_px, kHeight_px, 20);
    ASSERT_TRUE(writer) << writer.error().text();
    for (unsigned i = 0; i < times_s.size(); ++i) ASSERT_TRUE(writer->add(frameOf(i), times_s[i]));
    ASSERT_TRUE(writer->finish());
  }
  const std::vector<Decoded> frames = decode(file);
  ASSERT_EQ(frames.size(), times_s.size());
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_NEAR(frames[i].time_s, times_s[i], 0.002);
}

TEST(WebmWriter, AFileThatCannotBeWrittenIsNamed) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "missing" / "video.webm";
  const auto writer = WebmWriter::create(file, kWidth_px, kHeight_px, 25);
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().text(), HasSubstr(file.string()));
}

TEST(WebmWriter, AFrameOfAnotherSizeIsRefused) {
  const test::TemporaryFolder folder;
  auto writer = WebmWriter::create(folder.path() / "video.webm", kWidth_px, kHeight_px, 25);
  ASSERT_TRUE(writer) << writer.error().text();
  EXPECT_FALSE(writer->add(std::vector<std::uint8_t>(100), 0));
}

TEST(WebmWriter, AVideoThatIsGivenUpLeavesTheEarlierOne) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "video.webm";
  std::ofstream(file) << "earlier";
  {
    auto writer = WebmWriter::create(file, kWidth_px, kHeight_px, 25);
    ASSERT_TRUE(writer) << writer.error().text();
    ASSERT_TRUE(writer->add(frameOf(1), 0));
  }
  std::string held;
  std::getline(std::ifstream(file), held);
  EXPECT_EQ(held, "earlier");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "nothing of the other stays";
}

/// As of a disk that is full: the device takes nothing.
TEST(WebmWriter, WhatCannotBeWrittenOnIsSaidAndDoesNotWait) {
  if (!std::ofstream("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "video.webm";
  std::filesystem::create_symlink("/dev/full", file.string() + ".part");
  auto writer = WebmWriter::create(file, kWidth_px, kHeight_px, 25);
  if (!writer) return;  // said already
  Result<void> written = {};
  for (unsigned i = 0; written && i < 2000; ++i) written = writer->add(frameOf(i), i / 25.0);
  if (written) written = writer->finish();
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().text(), HasSubstr(file.string()));
}

}  // namespace
}  // namespace haptics
