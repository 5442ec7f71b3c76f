#include "common/surface/makers/image_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <cstdint>
#include <string>
#include <vector>

namespace haptics::image_field_test {
namespace {

using ::testing::HasSubstr;

template <class Channel>
std::string png(std::uint32_t width, std::uint32_t height, png_uint_32 format, const std::vector<Channel>& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  png_alloc_size_t size = 0;
  EXPECT_TRUE(png_image_write_get_memory_size(image, size, 0, pixels.data(), 0, nullptr)) << image.message;
  std::string bytes(size, '\0');
  EXPECT_TRUE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr)) << image.message;
  bytes.resize(size);
  return bytes;
}

std::string jpeg(int width, int height, const std::vector<unsigned char>& gray, int flags = 0) {
  unsigned char* data = nullptr;
  unsigned long size = 0;
  const auto handle = tjInitCompress();
  EXPECT_EQ(tjCompress2(handle, gray.data(), width, 0, height, TJPF_GRAY, &data, &size, TJSAMP_GRAY, 100, flags), 0);
  std::string bytes(reinterpret_cast<char*>(data), size);
  tjFree(data);
  tjDestroy(handle);
  return bytes;
}

std::vector<unsigned char> ramp(int width, int height) {
  std::vector<unsigned char> pixels;
  for (int i = 0; i < width * height; ++i) pixels.push_back(static_cast<unsigned char>(255 * i / (width * height - 1)));
  return pixels;
}

std::string reasonOf(std::string_view bytes) {
  const auto field = fieldFromImage(bytes);
  return field ? "accepted" : field.error().text();
}

TEST(ImageField, OfAPngIsItsBrightnessWithTheFirstRowOnTop) {
  const auto field = fieldFromImage(png<std::uint8_t>(3, 2, PNG_FORMAT_GRAY, {0, 51, 102, 153, 204, 255})).value();
  EXPECT_EQ(field.width(), 3U);
  EXPECT_EQ(field.height(), 2U);
  EXPECT_THAT(std::vector<float>(field.samples().begin(), field.samples().end()),
              ::testing::ElementsAre(0.6F, 0.8F, 1.F, 0.F, 0.2F, 0.4F));
}

TEST(ImageField, OfADeepPngKeepsItsSixteenBits) {
  const auto field = fieldFromImage(png<std::uint16_t>(2, 2, PNG_FORMAT_LINEAR_Y, {0, 1, 257, 65535})).value();
  EXPECT_FLOAT_EQ(field.samples()[3], 1 / 65535.F);
  EXPECT_FLOAT_EQ(field.samples()[0], 257 / 65535.F);
}

TEST(ImageField, OfAColouredPngWeighsColoursAsBrightness) {
  const auto field = fieldFromImage(png<std::uint8_t>(2, 2, PNG_FORMAT_RGB,
                                                      {255, 255, 255, 255, 0, 0,  //
                                                       0, 255, 0, 0, 0, 255}))
                         .value();
  const float white = field.samples()[2], red = field.samples()[3], green = field.samples()[0],
              blue = field.samples()[1];
  EXPECT_FLOAT_EQ(white, 1);
  EXPECT_GT(green, red);
  EXPECT_GT(red, blue);
  EXPECT_GT(blue, 0);
}

TEST(ImageField, TakesTransparentPartsForBlack) {
  const auto field =
      fieldFromImage(png<std::uint8_t>(2, 2, PNG_FORMAT_GA, {255, 255, 255, 0, 128, 255, 128, 0})).value();
  EXPECT_FLOAT_EQ(field.samples()[2], 1);
  EXPECT_FLOAT_EQ(field.samples()[3], 0);
  EXPECT_FLOAT_EQ(field.samples()[1], 0);
}

TEST(ImageField, OfAJpegIsItsBrightness) {
  const auto pixels = ramp(16, 8);
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    const auto field = fieldFromImage(jpeg(16, 8, pixels, flags)).value();
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 16; ++x) {
        EXPECT_NEAR(field.samples()[(7 - y) * 16 + x], pixels[y * 16 + x] / 255.0, 0.02);
      }
    }
  }
}

TEST(ImageField, IsRefusedWhenTheBytesAreNoImage) {
  for (const std::string_view bytes : {"", "GIF89a", "not an image at all", "\x89PN", "\xff\xd8"}) {
    EXPECT_EQ(reasonOf(bytes), "is not an image (PNG or JPEG)");
  }
  EXPECT_THAT(reasonOf("\x89PNG and then something else altogether"), HasSubstr("PNG image: "));
  EXPECT_THAT(reasonOf("\xff\xd8\xff and then something else altogether"), HasSubstr("JPEG image: "));
}

TEST(ImageField, IsRefusedWhenCutOffAnywhere) {
  for (const std::string& bytes : {png<std::uint8_t>(16, 8, PNG_FORMAT_GRAY, ramp(16, 8)), jpeg(16, 8, ramp(16, 8))}) {
    // The last twelve bytes of a PNG say only that it ends here; so do a JPEG's last two.
    for (std::size_t size = 0; size + 12 < bytes.size(); ++size) {
      EXPECT_NE(reasonOf(std::string_view(bytes).substr(0, size)), "accepted") << size;
    }
  }
}

TEST(ImageField, SurvivesAFlippedBitAnywhere) {
  for (std::string bytes : {png<std::uint8_t>(16, 8, PNG_FORMAT_GRAY, ramp(16, 8)), jpeg(16, 8, ramp(16, 8))}) {
    int refusals = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ 1 << bit % 8);
      refusals += !fieldFromImage(bytes);
      bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ 1 << bit % 8);
    }
    EXPECT_GT(refusals, 0);
  }
}

TEST(ImageField, IsRefusedWithASideThatIsTooLongOrTooShort) {
  const std::vector<unsigned char> row(5000 * 2);
  EXPECT_EQ(reasonOf(png<std::uint8_t>(5000, 2, PNG_FORMAT_GRAY, row)), "width: is 5000 samples; 2 to 4096 are taken");
  EXPECT_EQ(reasonOf(png<std::uint8_t>(2, 5000, PNG_FORMAT_GRAY, row)), "height: is 5000 samples; 2 to 4096 are taken");
  EXPECT_EQ(reasonOf(jpeg(5000, 2, row)), "width: is 5000 samples; 2 to 4096 are taken");
  EXPECT_EQ(reasonOf(jpeg(1, 100, row)), "width: is 1 samples; 2 to 4096 are taken");
}

}  // namespace
}  // namespace haptics::image_field_test
