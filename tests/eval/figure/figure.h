#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"

namespace haptics::eval {

/// sRGB, 0 to 1.
struct Colour {
  double red, green, blue;
};

enum class Marker { kDisc, kDiamond, kCross, kNone };  ///< Without one a curve is dashed: of a formula, not measured.

/// How a curve looks in every panel, and what the legend says of it.
struct Style {
  std::string name;
  std::string note;  ///< A second, smaller line.
  Colour colour;
  Marker marker = Marker::kDisc;
  bool strong = false;  ///< The one that the figure is about: wider, on top.
};

struct CurvePoint {
  double x, y;
  std::string label;                            ///< Beside the marker, where no curve passes; may be empty.
  std::optional<Marker> marker = std::nullopt;  ///< None: the style's.
};

struct Curve {
  std::size_t style;
  std::vector<CurvePoint> points;
};

/// Decades: 10^low to 10^high.
struct Decades {
  int low, high;
};

/// A value of y, dashed.
struct Threshold {
  double y;
  std::string label;  ///< Below its right end; left out where a curve passes there.
};

/// A value of x, dashed.
struct UprightMark {
  double x;
  std::size_t style;  ///< Whose colour it has.
  std::string label;  ///< Along its upper end, on a side where no curve passes.
};

/// Logarithmic in both. Points beyond the decades are drawn on the rim.
struct Panel {
  std::string title;
  std::string xLabel;
  std::string yLabel;
  Decades x, y;
  std::vector<Curve> curves;
  std::optional<Threshold> threshold = std::nullopt;
  std::optional<UprightMark> mark = std::nullopt;
};

/// Panels in rows, a legend beside them.
struct Figure {
  std::string title;
  std::vector<std::string> caption;  ///< Lines under the title.
  std::size_t columns = 1;
  std::vector<Panel> panels;
  std::string legendTitle;
  std::vector<Style> styles;
  std::vector<std::string> legendNotes;  ///< Lines under the legend.
};

/// Smallest decades that hold the values; at least one.
[[nodiscard]] Decades decadesOf(const std::vector<double>& values);

/// Draws with VTK into a PNG and an SVG of the same look. Needs an X display: VirtualDisplay::ensure(). Refused: a file that cannot
/// be written.
[[nodiscard]] Result<void> drawFigure(const Figure& figure, const std::filesystem::path& png,
                                      const std::filesystem::path& svg);

}  // namespace haptics::eval
