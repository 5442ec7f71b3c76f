#include "graphics_client/application/height_map.h"

#include <gmock/gmock.h>

#include <QFile>
#include <QImage>
#include <QTemporaryDir>

namespace haptics::height_map_test {
namespace {

using testing::HasSubstr;

struct HeightMap : testing::Test {
  QTemporaryDir folder;

  [[nodiscard]] QString path(const char* name) const { return folder.filePath(name); }
  QString save(const QImage& image, const char* name) {
    EXPECT_TRUE(image.save(path(name))) << name;
    return path(name);
  }
  QString write(const QByteArray& bytes, const char* name) {
    QFile file(path(name));
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(bytes);
    return path(name);
  }
};

/// White at the upper left.
QImage twoByTwo(QImage::Format format) {
  QImage image(2, 2, format);
  image.fill(Qt::black);
  image.setPixelColor(0, 0, Qt::white);
  image.setPixelColor(1, 1, QColor(51, 51, 51));
  return image;
}

TEST_F(HeightMap, HasBrightnessWithItsFirstRowHighest) {
  for (const auto& [format, name] : {std::pair{QImage::Format_Grayscale8, "gray.png"},
                                     {QImage::Format_RGB32, "color.png"},
                                     {QImage::Format_Grayscale8, "gray.pgm"},
                                     {QImage::Format_RGB32, "color.bmp"}}) {
    const auto field = readHeightMap(save(twoByTwo(format), name));
    ASSERT_TRUE(field) << name << ": " << field.error().text();
    EXPECT_EQ((*field)->width(), 2U);
    EXPECT_NEAR((*field)->samples()[0], 0, 1e-6) << name;
    EXPECT_NEAR((*field)->samples()[1], 0.2, 1e-3) << name;
    EXPECT_NEAR((*field)->samples()[2], 1, 1e-6) << name;
    EXPECT_NEAR((*field)->samples()[3], 0, 1e-6) << name;
  }
}

TEST_F(HeightMap, KeepsSixteenBits) {
  QImage image(2, 2, QImage::Format_Grayscale16);
  image.fill(Qt::black);
  reinterpret_cast<quint16*>(image.scanLine(1))[0] = 1;
  const auto field = readHeightMap(save(image, "deep.png"));
  ASSERT_TRUE(field) << field.error().text();
  EXPECT_FLOAT_EQ((*field)->samples()[0], 1 / 65535.0F);
}

TEST_F(HeightMap, SaysWhatIsNoPicture) {
  for (const QString& file : {path("absent.png"), write("not a picture", "text.png"), write({}, "empty.pgm")}) {
    const auto field = readHeightMap(file);
    ASSERT_FALSE(field) << file.toStdString();
    EXPECT_THAT(field.error().text(), HasSubstr("is no picture"));
  }
}

TEST_F(HeightMap, SaysThatAPictureIsTooLargeBeforeItIsDecoded) {
  const auto field = readHeightMap(write("P5 5000 3 255\n", "large.pgm"));
  ASSERT_FALSE(field);
  EXPECT_THAT(field.error().text(), HasSubstr("has 5000 x 3 pixels; scale it to 2048"));
}

TEST_F(HeightMap, RefusesWhatIsDamagedAndASinglePixel) {
  QFile whole(save(twoByTwo(QImage::Format_Grayscale8).scaled(64, 64), "whole.png"));
  ASSERT_TRUE(whole.open(QIODevice::ReadOnly));
  EXPECT_FALSE(readHeightMap(write(whole.readAll().left(60), "half.png")));
  EXPECT_FALSE(readHeightMap(save(QImage(1, 1, QImage::Format_Grayscale8), "pixel.png")));
}

}  // namespace
}  // namespace haptics::height_map_test
