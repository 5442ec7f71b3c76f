#include "graphics_client/viewer/picture_sheet.h"

#include <vtkImageAppend.h>
#include <vtkImageConstantPad.h>
#include <vtkImageResize.h>
#include <vtkNew.h>

#include <algorithm>

#include "graphics_client/viewer/render_window.h"

namespace haptics {
namespace {

/// Fractions of a picture's share of the run: it is taken between the two.
constexpr double kEarliest = 0.3, kLatest = 0.95;
/// Between two pictures, white.
constexpr int kPicturesGap_px = 6;

vtkSmartPointer<vtkImageData> appended(const std::vector<vtkSmartPointer<vtkImageData>>& pictures, int axis) {
  vtkNew<vtkImageAppend> append;
  append->SetAppendAxis(axis);
  for (const auto& picture : pictures) append->AddInputData(picture);
  append->Update();
  return append->GetOutput();
}

}  // namespace

bool PictureSheet::isDue(double time_s, bool isWorthSeeing) const {
  if (pictures_.size() >= std::size_t{kColumns * kRows}) return false;
  const double share = time_s / duration_s_ * kColumns * kRows - static_cast<double>(pictures_.size());
  return share >= (isWorthSeeing ? kEarliest : kLatest);
}

void PictureSheet::add(vtkImageData* picture) {
  const auto* size_px = picture->GetDimensions();
  const int height_px = std::max(1, kPictureWidth_px * size_px[1] / size_px[0]);
  vtkNew<vtkImageResize> resize;
  resize->SetInputData(picture);
  resize->SetOutputDimensions(kPictureWidth_px, height_px, 1);
  vtkNew<vtkImageConstantPad> pad;
  pad->SetInputConnection(resize->GetOutputPort());
  pad->SetOutputWholeExtent(0, kPictureWidth_px + kPicturesGap_px - 1, 0, height_px + kPicturesGap_px - 1, 0, 0);
  pad->SetConstant(255);
  pad->Update();
  pictures_.emplace_back(pad->GetOutput());
}

/// A last row that is not full is left out, if there is a full one.
Result<void> PictureSheet::write(const std::filesystem::path& file) const {
  std::vector<vtkSmartPointer<vtkImageData>> rows;
  for (auto from = pictures_.begin(); from != pictures_.end();) {
    const auto to = from + std::min<std::ptrdiff_t>(kColumns, pictures_.end() - from);
    if (rows.empty() || to - from == kColumns) rows.insert(rows.begin(), appended({from, to}, 0));  // lowest first
    from = to;
  }
  return writePng(appended(rows, 1), file);
}

}  // namespace haptics
