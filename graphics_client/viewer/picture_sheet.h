#pragma once

#include <vtkImageData.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// Small pictures of a run in the order in which they were taken, row by row on one sheet: shows a scene that moves.
class PictureSheet {
 public:
  static constexpr int kColumns = 3, kRows = 2;
  static constexpr int kPictureWidth_px = 360;  ///< Of each on the sheet.

  /// @param duration_s  Of the run, > 0.
  explicit PictureSheet(double duration_s) : duration_s_(duration_s) {}

  /// The next picture is to be taken now: in its share of the run, as soon as there is something to see.
  [[nodiscard]] bool isDue(double time_s, bool isWorthSeeing) const;
  /// All of one size.
  void add(vtkImageData* picture);
  [[nodiscard]] bool isEmpty() const { return pictures_.empty(); }
  /// As PNG; not when empty. Refused when the file cannot be written.
  [[nodiscard]] Result<void> write(const std::filesystem::path& file) const;

 private:
  double duration_s_;
  std::vector<vtkSmartPointer<vtkImageData>> pictures_;
};

}  // namespace haptics
