#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/error/error.h"

namespace haptics::eval {

/// On the diagonal.
struct MatrixEntry {
  std::string title;
  std::string note;
};

struct MatrixBar {
  std::string name;   ///< With its unit.
  double share = 0;   ///< Of the limit: 1 is at it.
  std::string value;  ///< In the name's unit.
};

/// Of two entries, row before column: a plot above the diagonal, bars at the same place below.
struct MatrixCell {
  std::size_t row = 0, column = 0;
  std::string title;
  std::string plotTitle;                                      ///< After it.
  std::vector<std::pair<double, double>> measured, expected;  ///< Over seconds.
  std::vector<MatrixBar> bars;
};

struct Matrix {
  std::string title;
  std::vector<std::string> caption;
  std::vector<MatrixEntry> entries;
  std::vector<MatrixCell> cells;
};

/// A PNG, by VTK. Needs an X display: VirtualDisplay::ensure(). Refused: a file that cannot be written.
[[nodiscard]] Result<void> drawMatrix(const Matrix& matrix, const std::filesystem::path& png);

}  // namespace haptics::eval
