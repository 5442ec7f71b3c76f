#include "graphics_client/viewer/picture_sheet.h"

#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <algorithm>

#include "tests/common/temporary_folder.h"

namespace haptics::picture_sheet_test {
namespace {

constexpr int kCount = PictureSheet::kColumns * PictureSheet::kRows;

vtkSmartPointer<vtkImageData> gray(int value) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(800, 600, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  std::fill_n(static_cast<unsigned char*>(image->GetScalarPointer()), 3 * 800 * 600, static_cast<unsigned char>(value));
  return image;
}

TEST(PictureSheet, WantsItsPicturesSpreadOverTheRunPreferablyOfContacts) {
  PictureSheet sheet(60);
  EXPECT_FALSE(sheet.isDue(2.9, true));
  EXPECT_TRUE(sheet.isDue(3.1, true));
  EXPECT_FALSE(sheet.isDue(9, false)) << "a contact may still come";
  EXPECT_TRUE(sheet.isDue(9.9, false));
  sheet.add(gray(0));
  EXPECT_FALSE(sheet.isDue(12, true));
  EXPECT_TRUE(sheet.isDue(13.1, true));
  for (int i = 1; i < kCount; ++i) sheet.add(gray(0));
  EXPECT_FALSE(sheet.isDue(59, true)) << "is full";
}

TEST(PictureSheet, IsReadRowByRow) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "sheet.png";
  PictureSheet sheet(60);
  for (int i = 0; i < kCount; ++i) sheet.add(gray(20 * i));
  ASSERT_TRUE(sheet.write(file));
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  const int width = image->GetDimensions()[0] / PictureSheet::kColumns;
  const int height = image->GetDimensions()[1] / PictureSheet::kRows;
  EXPECT_GE(width, PictureSheet::kPictureWidth_px);
  EXPECT_GE(height, PictureSheet::kPictureWidth_px * 3 / 4);
  for (int i = 0; i < kCount; ++i) {
    const int column = i % PictureSheet::kColumns, row = i / PictureSheet::kColumns;
    const int x = column * width + width / 2, y = (PictureSheet::kRows - 1 - row) * height + height / 2;
    EXPECT_EQ(image->GetScalarComponentAsDouble(x, y, 0, 0), 20 * i);
  }
}

}  // namespace
}  // namespace haptics::picture_sheet_test
