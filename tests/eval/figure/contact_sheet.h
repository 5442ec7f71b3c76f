#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/error/error.h"
#include "tests/eval/figure/canvas.h"

namespace haptics::eval {

struct SheetCurve {
  std::string name;  ///< Beside the plot's title, in its colour; may be empty.
  Colour colour;
  std::vector<std::pair<double, double>> points;
  double width = 1.6;
};

/// Linear in both.
struct SheetPlot {
  std::string title;
  std::string xLabel;
  std::vector<SheetCurve> curves;
  bool fromZero = false;  ///< y begins at 0.
};

/// One specimen: a picture, plots beside it, and what is to be said of it.
struct SheetCard {
  std::string title;
  bool good = true;
  Raster picture;
  std::string scale;  ///< Of the picture, below it.
  std::vector<SheetPlot> plots;
  std::vector<std::string> verdict;
};

/// Squares in rows and columns.
struct SheetGrid {
  std::string title;
  std::vector<std::vector<Colour>> rows;  ///< The lowest first.
};

struct SheetKey {
  Colour colour;
  std::string meaning;
};

/// Grids beside one another that share their axes.
struct SheetGrids {
  std::string title;
  std::vector<SheetKey> key;
  std::vector<std::string> columnNames;
  std::vector<std::string> rowNames;
  std::string columnLabel;
  std::string rowLabel;
  std::vector<SheetGrid> grids;
};

struct ContactSheet {
  std::string title;
  std::vector<std::string> caption;
  std::vector<SheetCard> cards;  ///< In two columns.
  SheetGrids grids;
  std::string plotsTitle;
  std::vector<SheetPlot> plots;  ///< In one row.
};

/// A PNG, by VTK. Needs an X display: VirtualDisplay::ensure(). Refused: a file that cannot be written.
[[nodiscard]] Result<void> drawContactSheet(const ContactSheet& sheet, const std::filesystem::path& png);

}  // namespace haptics::eval
